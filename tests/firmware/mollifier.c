/* A table of a compact mollifier in the plane and of its field, in static buffers. */
#include "board.h"
#include "mollis.h"
#include "report.h"

enum { POINTS = 9 };

static float r[POINTS], density[POINTS], slope[POINTS], potential[POINTS], gradient[POINTS], hessian[POINTS], mass[POINTS];

static void table(int32_t order, int32_t exponent) {
  const mollis_mollifier mollifier = {MOLLIS_MOLLIFIER_COMPACT, order, exponent};
  int k;
  put_text("order");
  put_number((uint32_t)order);
  put_text(" exponent");
  put_number((uint32_t)exponent);
  put_status(" status", mollis_mollifier2_eval_f32(mollifier, 1.5f, POINTS, r, density, slope, potential, gradient,
                                                   hessian, mass));
  for (k = 0; k < POINTS; ++k) {
    put_float(r[k]);
    put_float(density[k]);
    put_float(slope[k]);
    put_float(potential[k]);
    put_float(gradient[k]);
    put_float(hessian[k]);
    put_float(mass[k]);
    put_line();
  }
}

int run(void) {
  uint32_t before;
  int k;
  for (k = 0; k < POINTS; ++k) r[k] = 0.25f * (float)k;
  before = board_instructions();
  table(2, 3);
  put_measure("instructions", board_instructions() - before);
  table(4, 9);
  table(8, 1);
  put_measure("stack", board_stack());
  return 0;
}
