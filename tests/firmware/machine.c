/* Common to both bare machines: memory before main, depth of the stack, console and exit. */
#include <stddef.h>

#include "board.h"
#include "semihosting.h"

extern uint32_t __data_start[], __data_end[], __data_load[], __bss_start[], __bss_end[], __stack_limit[], __stack_top[];

/* Small functions: those of the compiler's library are optimised for speed and take 400 bytes. */
void *memcpy(void *to, const void *from, size_t n) {
  char *t = to;
  const char *f = from;
  while (n-- > 0) *t++ = *f++;
  return to;
}

void *memset(void *to, int value, size_t n) {
  char *t = to;
  while (n-- > 0) *t++ = (char)value;
  return to;
}

void machine_start(void);
void machine_init(void);

static const uint32_t UNUSED = 0xa5a5a5a5u;

void board_write(const char *text) { semihosting(SEMIHOSTING_WRITE0, text); }

uint32_t board_stack(void) {
  const volatile uint32_t *word = __stack_limit;
  while (word < __stack_top && *word == UNUSED) ++word;
  return (uint32_t)((uintptr_t)__stack_top - (uintptr_t)word);
}

void machine_start(void) {
  volatile uint32_t *to;
  const uint32_t *from = __data_load;
  uintptr_t status[2];
  /* The stack in use ends a little below this frame. All bytes below are filled with the pattern. */
  volatile uint32_t *end = (volatile uint32_t *)((uintptr_t)__builtin_frame_address(0) - 128);
  for (to = __stack_limit; to < end; ++to) *to = UNUSED;
  for (to = __data_start; to < __data_end; ++to, ++from) *to = *from;
  for (to = __bss_start; to < __bss_end; ++to) *to = 0;
  machine_init();
  status[0] = SEMIHOSTING_STOPPED;
  status[1] = (uintptr_t)run();
  semihosting(SEMIHOSTING_EXIT, status);
  for (;;) {
  }
}
