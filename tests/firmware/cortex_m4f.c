/* Cortex-M4F (QEMU mps2-an386): vectors, FPU, SysTick as a clock. */
#include <stddef.h>

#include "board.h"
#include "semihosting.h"

extern uint32_t __stack_top[];

void machine_start(void);
void machine_init(void);

/* The names of the memory functions that compilers for ARM use. */
void *memcpy(void *to, const void *from, size_t n);
void *memset(void *to, int value, size_t n);
void __aeabi_memcpy(void *to, const void *from, size_t n) { memcpy(to, from, n); }
void __aeabi_memcpy4(void *to, const void *from, size_t n) { memcpy(to, from, n); }
void __aeabi_memcpy8(void *to, const void *from, size_t n) { memcpy(to, from, n); }
void __aeabi_memset(void *to, size_t n, int value) { memset(to, value, n); }
void __aeabi_memset4(void *to, size_t n, int value) { memset(to, value, n); }
void __aeabi_memset8(void *to, size_t n, int value) { memset(to, value, n); }
void __aeabi_memclr(void *to, size_t n) { memset(to, 0, n); }
void __aeabi_memclr4(void *to, size_t n) { memset(to, 0, n); }
void __aeabi_memclr8(void *to, size_t n) { memset(to, 0, n); }

static void fault(void) {
  uintptr_t status[2] = {SEMIHOSTING_STOPPED, 99};
  semihosting(SEMIHOSTING_EXIT, status);
  for (;;) {
  }
}

__attribute__((section(".vectors"), used)) static const uintptr_t vectors[16] = {
    (uintptr_t)__stack_top, (uintptr_t)machine_start, (uintptr_t)fault, (uintptr_t)fault,
    (uintptr_t)fault,       (uintptr_t)fault,         (uintptr_t)fault,
};

uintptr_t semihosting(uintptr_t request, const void *argument) {
  register uintptr_t r0 __asm__("r0") = request;
  register const void *r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

static volatile uint32_t *const CPACR = (volatile uint32_t *)0xe000ed88;
static volatile uint32_t *const SYSTICK = (volatile uint32_t *)0xe000e010;

void machine_init(void) {
  *CPACR |= 0xfu << 20; /* coprocessors 10 and 11, the FPU */
  __asm__ volatile("dsb\n isb" ::: "memory");
  SYSTICK[1] = 0xffffff; /* reload */
  SYSTICK[2] = 0;        /* current */
  SYSTICK[0] = 5;        /* on, processor clock, no interrupt */
}

/* QEMU with -icount shift=0 executes an instruction in one virtual nanosecond; the clock of this machine has 25 MHz. */
uint32_t board_instructions(void) { return (0xffffff - SYSTICK[2]) * 40u; }
