/* The host: console on standard output. */
#include <stdio.h>

#include "board.h"

void board_write(const char *text) { fputs(text, stdout); }
uint32_t board_instructions(void) { return 0; }
uint32_t board_stack(void) { return 0; }
int main(void) { return run(); }
