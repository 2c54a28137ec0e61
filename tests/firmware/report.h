/* Output without printf: raw bits in hexadecimal, exact to compare. A line that begins with '#' is a measurement and differs
 * between machines. */
#ifndef REPORT_H
#define REPORT_H

#include <stdint.h>

void put_text(const char *text);
void put_hex(uint32_t value);
void put_number(uint32_t value);
void put_float(float value);
void put_line(void);
/* "name value", a line. */
void put_status(const char *name, int32_t status);
/* "#name value", a line. */
void put_measure(const char *name, uint32_t value);

#endif
