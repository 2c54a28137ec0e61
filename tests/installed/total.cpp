/* total.c in C++: the total mass and the centre of 5000 equal points on a line, from a mesh, with a pool of threads if POOL is defined. The result
 * is 0 if they are 1250 and the middle. */
#include "mollis.hpp"

#include <cmath>
#include <vector>

int main() {
  constexpr std::size_t n = 5000;
  std::vector<std::array<double, 2>> x(n), gradient(n), alone(n);
  const std::vector<double> mass(n, 0.25);
  for (std::size_t k = 0; k < n; ++k) x[k] = {(double(k) + 0.5) / n, 0.5};
  const mollis::mesh mesh = {{0.0, 0.0}, {1.0, 1.0}, {16, 16}};
  mollis::workspace workspace;
  std::array<double, 3> total{};
  mollis::grid_outputs<double> out;
  out.gradient = alone;
  mollis::grid<double>(mesh, {x, mass}, {}, out, workspace);
  mollis::grid_options options;
#ifdef POOL
  mollis::result result;
  mollis::pool pool(2, result);
  if (!result) return 2;
  pool = mollis::pool(3);
  options.run.executor = pool;
#endif
  out.gradient = gradient;
  out.total = &total;
  mollis::grid<double>(mesh, {x, mass}, {}, out, workspace, options);
  if (gradient != alone) return 3;
  /* Each mass is rounded by at most 2^-50 of the whole: 6e-9 for all. */
  return std::fabs(total[0] - 1250) < 1e-8 && std::fabs(total[1] - 0.5) < 1e-6 ? 0 : 1;
}
