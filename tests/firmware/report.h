/* Output without printf: raw bits in hexadecimal, which can be compared exactly. A line that begins with '#' is a measurement
 * and differs between machines. */
#ifndef REPORT_H
#define REPORT_H

#include <stdint.h>

void put_text(const char *text);
void put_hex(uint32_t value);
void put_number(uint32_t value);
void put_float(float value);
void put_line(void);
/* Prints the line "name value". */
void put_status(const char *name, int32_t status);
/* Prints the line "#name value". */
void put_measure(const char *name, uint32_t value);

#endif
