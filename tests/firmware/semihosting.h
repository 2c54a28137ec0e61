/* Console and exit through the debugger (or QEMU in its place). */
#ifndef SEMIHOSTING_H
#define SEMIHOSTING_H

#include <stdint.h>

/* One request; each machine has its own trap. */
uintptr_t semihosting(uintptr_t request, const void *argument);

enum { SEMIHOSTING_WRITE0 = 0x04, SEMIHOSTING_EXIT = 0x20, SEMIHOSTING_STOPPED = 0x20026 };

#endif
