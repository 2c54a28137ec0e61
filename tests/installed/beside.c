/* Linked with all members of an installed archive and all of another library written in Rust. */
#include "mollis.h"

size_t second_length(size_t n);

int main(void) {
  /* [0.0, 1.0, 2.0] */
  return mollis_abi_version() == 0 || second_length(3) != 15;
}
