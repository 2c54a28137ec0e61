/* Console and exit through the debugger (here QEMU). */
#ifndef SEMIHOSTING_H
#define SEMIHOSTING_H

#include <stdint.h>

/* One request. Each machine has its own trap instruction. */
uintptr_t semihosting(uintptr_t request, const void *argument);

enum { SEMIHOSTING_WRITE0 = 0x04, SEMIHOSTING_EXIT = 0x20, SEMIHOSTING_STOPPED = 0x20026 };

#endif
