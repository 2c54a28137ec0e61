#include "report.h"

#include "board.h"

void put_text(const char *text) { board_write(text); }

void put_line(void) { board_write("\n"); }

void put_hex(uint32_t value) {
  char text[10];
  int k;
  text[0] = ' ';
  for (k = 8; k > 0; --k, value >>= 4) text[k] = "0123456789abcdef"[value & 15];
  text[9] = 0;
  board_write(text);
}

void put_number(uint32_t value) {
  char text[12];
  int k = 11;
  text[k] = 0;
  do {
    text[--k] = (char)('0' + value % 10);
    value /= 10;
  } while (value != 0);
  text[--k] = ' ';
  board_write(text + k);
}

void put_float(float value) {
  union {
    float value;
    uint32_t bits;
  } raw;
  raw.value = value;
  put_hex(raw.bits);
}

void put_status(const char *name, int32_t status) {
  board_write(name);
  put_number((uint32_t)status);
  put_line();
}

void put_measure(const char *name, uint32_t value) {
  board_write("#");
  put_status(name, (int32_t)value);
}
