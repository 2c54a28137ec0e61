/* Runs on the host only: the macros of the header equal the size queries, for every small n and some large ones. */
#include <stdio.h>

#include "mollis.h"

static _Alignas(MOLLIS_ALIGN) unsigned char kernel[MOLLIS_KERNEL2_NEWTONIAN_BYTES_F32];

int main(void) {
  const mollis_mollifier mollifier = {MOLLIS_MOLLIFIER_COMPACT, 4, 5};
  const mollis_kernel_term newtonian = {MOLLIS_KERNEL_NEWTONIAN, 0, 1.0, {0.0, 0.0}};
  mollis_pks_attraction attraction = {MOLLIS_PKS_ATTRACTION_SUM, 0, 0, 0, kernel, sizeof kernel, 0.0, 0.0};
  mollis_pks_options options;
  float some[2] = {0.0f, 0.0f};
  mollis_particles2_f32 particles = {.positions = {some}, .masses = some, .density = some};
  size_t n, bytes = 0;
  int few = 5;
  mollis_pks_options_init(&options, sizeof options);
  if (mollis_kernel2_bytes_f32(&newtonian, 1, 0, mollifier, &bytes) || bytes != sizeof kernel) return 1;
  if (mollis_kernel2_prepare_f32(kernel, sizeof kernel, &newtonian, 1, 0, mollifier, 0.5f)) return 2;
  for (n = 0; n < 200000; n += n < 3000 ? 1 : n / 3) {
    particles.n = n;
    if (mollis_blob2_workspace_bytes_f32(kernel, sizeof kernel, &particles, 0, 0, 0, &bytes)) return 3;
    if (bytes != MOLLIS_BLOB2_WORKSPACE_BYTES_F32(n)) {
      printf("blob, n = %zu: %zu bytes, the macro says %zu\n", n, bytes, (size_t)MOLLIS_BLOB2_WORKSPACE_BYTES_F32(n));
      return 4;
    }
    if (mollis_pks_workspace_bytes_f32(n, &attraction, &options, 0, &bytes)) return 5;
    if (bytes != MOLLIS_PKS_WORKSPACE_BYTES_F32(n)) {
      printf("pks, n = %zu: %zu bytes, the macro says %zu\n", n, bytes, (size_t)MOLLIS_PKS_WORKSPACE_BYTES_F32(n));
      return 6;
    }
  }
  /* An int serves as well, whose products would overflow. */
  few *= 100000000;
  if (MOLLIS_BLOB2_WORKSPACE_BYTES_F32(few) != MOLLIS_BLOB2_WORKSPACE_BYTES_F32((size_t)few)) return 7;
  if (MOLLIS_PKS_WORKSPACE_BYTES_F32(few) != MOLLIS_PKS_WORKSPACE_BYTES_F32((size_t)few)) return 8;
  puts("sizes agree");
  return 0;
}
