/* What a program needs of the machine: a console, counters and an exit. cortex_m4f.c, rv32imafc.c and host.c implement it, so
 * one program runs on all three and its output can be compared. */
#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

/* The program, called by the machine; its result is the exit status. */
int run(void);

/* Writes a text. */
void board_write(const char *text);

/* Instructions executed so far (the host has no such counter: 0). Differences below 2^29 are exact to one tick of the
 * counter, which is 40 instructions on Cortex-M4F and 1 on RISC-V. */
uint32_t board_instructions(void);

/* Bytes of stack used at the deepest point so far; 0 on the host. */
uint32_t board_stack(void);

#endif
