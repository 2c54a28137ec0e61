/* RV32IMAFC (QEMU virt): entry, FPU, the retired-instruction counter. */
#include "board.h"
#include "semihosting.h"

void machine_init(void);

__asm__(
    ".section .vectors, \"ax\"\n"
    ".globl _start\n"
    "_start:\n"
    "  la sp, __stack_top\n"
    "  la t0, fault\n"
    "  csrw mtvec, t0\n"
    "  li t0, 0x2000\n" /* mstatus.FS = initial: the FPU is on */
    "  csrs mstatus, t0\n"
    "  csrw fcsr, zero\n"
    "  j machine_start\n"
    ".text\n");

__attribute__((used, aligned(4))) static void fault(void) {
  uintptr_t status[2] = {SEMIHOSTING_STOPPED, 99};
  semihosting(SEMIHOSTING_EXIT, status);
  for (;;) {
  }
}

__attribute__((noinline, aligned(16))) uintptr_t semihosting(uintptr_t request, const void *argument) {
  register uintptr_t a0 __asm__("a0") = request;
  register const void *a1 __asm__("a1") = argument;
  /* These three instructions mark a semihosting request. They must be uncompressed and on one page. */
  __asm__ volatile(
      ".option push\n.option norvc\n.balign 16\n"
      "slli x0, x0, 0x1f\n ebreak\n srai x0, x0, 7\n"
      ".option pop\n"
      : "+r"(a0)
      : "r"(a1)
      : "memory");
  return a0;
}

void machine_init(void) {}

uint32_t board_instructions(void) {
  uint32_t count;
  __asm__ volatile("csrr %0, minstret" : "=r"(count));
  return count;
}
