/*
 * Four uses of mollis from C++: the velocities of vortices that are an array of structures, steps of vortices and of blobs that attract each
 * other, and coalescing particles with a random generator of the program's own. The result is 0 if what is known of each holds.
 *
 * At the portable level every machine computes the same bits, and particles.c, particles.f90 and this program print the same lines.
 */
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "mollis.hpp"

namespace {

using place = std::array<double, 2>;

struct vortex {
  place x;
  double circulation, core;
  place velocity;
};

/* Marsaglia's xorshift, as a UniformRandomBitGenerator. */
class xorshift {
public:
  using result_type = std::uint64_t;
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return UINT64_MAX; }
  result_type operator()() {
    x_ ^= x_ << 13;
    x_ ^= x_ >> 7;
    x_ ^= x_ << 17;
    return x_;
  }

private:
  result_type x_ = 88172645463325252;
};

/* How all calls run. */
mollis::run portable() {
  mollis::run run;
  run.level = MOLLIS_LEVEL_PORTABLE;
  return run;
}

/* n points without a pattern. */
std::vector<place> places(int n) {
  std::vector<place> x;
  for (int k = 1; k <= n; ++k) x.push_back({(37 * k % 101 - 50) / 64.0, (53 * k % 103 - 51) / 64.0});
  return x;
}

/* Two equal vortices with the core of Vatistas turn about each other with speed g d / (2 pi (d^4 + core^4)^(1/2)), d being their distance. The
 * array is read and written where it is. */
bool vortices(mollis::workspace &workspace) {
  std::vector<vortex> v = {{{0.0, 0.0}, 2.0, 0.1, {}}, {{0.5, 0.0}, 2.0, 0.2, {}}};
  const mollis::kernel<double, 2> kernel(mollis::newtonian(1.0), mollis::vatistas(), 0.1);
  mollis::sources<double, 2> sources;
  sources.positions = {v, &vortex::x};
  sources.masses = {v, &vortex::circulation};
  sources.radii = {v, &vortex::core};
  mollis::outputs<double, 2> outputs;
  outputs.gradient = {v, &vortex::velocity};
  mollis::field_options options;
  options.combination[0] = 0;
  options.combination[1] = 1;
  options.run = portable();
  mollis::field(kernel, sources, outputs, workspace, options);
  const double known = 2.0 * 0.5 / (2 * std::acos(-1.0) * std::sqrt(std::pow(0.5, 4) + std::pow(0.1, 4)));
  std::printf("vortices: velocity%24.16E%24.16E\n", v[1].velocity[0], v[1].velocity[1]);
  return std::fabs(v[1].velocity[1] - known) < 1e-15 && std::fabs(v[1].velocity[0]) < 1e-15;
}

/* Two equal vortices at the distance d turn about their centre at the rate g / (pi d^2), counter-clockwise, in steps of the blob method. Its velocity is minus the
 * gradient output of a sum, so the combination is (0, -1). */
bool turning(mollis::workspace &workspace) {
  std::vector<place> x = {{0.25, 0.0}, {-0.25, 0.0}};
  const std::vector<double> circulation = {2.0, 2.0};
  const double quarter = std::acos(-1.0) * std::acos(-1.0) / 16;
  const mollis::kernel<double, 2> kernel(mollis::newtonian(1.0), mollis::compact(4, 5), 0.1);
  mollis::blob_options<double, 2> options;
  options.combination[0] = 0;
  options.combination[1] = -1;
  options.run = portable();
  const mollis_blob_report report = mollis::blob_step(kernel, {x, circulation}, {}, quarter / 50, 50, workspace, options);
  std::printf("a quarter of a turn: the first at%24.16E%24.16E\n", x[0][0], x[0][1]);
  return report.steps == 50 && std::fabs(x[0][0]) < 1e-7 && std::fabs(x[0][1] - 0.25) < 1e-7;
}

/* Blobs that attract each other keep their centre of mass. */
bool blobs(mollis::workspace &workspace) {
  std::vector<place> x = places(128);
  const std::vector<double> mass(x.size(), 1.0 / 128);
  const mollis::kernel<double, 2> kernel(mollis::newtonian(1.0), mollis::compact(4, 5), 0.3);
  const place before = mollis::moments<double, 2>(x, mass).centre;
  mollis::blob_options<double, 2> options;
  options.run = portable();
  const mollis_blob_report report = mollis::blob_step(kernel, {x, mass}, {}, 0.01, 20, workspace, options);
  const place after = mollis::moments<double, 2>(x, mass).centre;
  std::printf("blobs after %d steps: the last at%24.16E%24.16E\n", int(report.steps), x.back()[0], x.back()[1]);
  return report.steps == 20 && std::fabs(after[0] - before[0]) < 1e-15 && std::fabs(after[1] - before[1]) < 1e-15;
}

/* Particles merge, and mass is lost by rounding alone. */
bool coalescence(mollis::workspace &workspace) {
  std::vector<place> x = places(200);
  const std::size_t n = x.size();
  std::vector<double> mass(n, 0.125);
  std::vector<std::uint64_t> labels, absorbed(n);
  std::vector<mollis_pks_event> merges(n);
  for (std::size_t k = 1; k <= n; ++k) labels.push_back(k);
  const mollis::kernel<double, 2> kernel(mollis::newtonian(1.0), mollis::compact(2, 4), 0.01);
  xorshift engine;
  mollis::pks_options options;
  options.chi = 3;
  options.noise = 0.125;
  options.generator = engine;
  options.run = portable();
  mollis::pks_progress progress(n);
  mollis::pks_events events(merges, absorbed);
  const bool whole = mollis::pks_step<double>({x, mass, labels}, progress, mollis::pks_attraction<double>(kernel), 1e-3, 20,
                                              events, workspace, options);
  double total = 0;
  for (std::size_t k = 0; k < progress.count; ++k) total += mass[k];
  const place &last = x[progress.count - 1];
  std::printf("coalescing: %d particles left after %d merges, mass %12.9f, the last at%24.16E%24.16E\n", int(progress.count),
              int(events.written), total, last[0], last[1]);
  return whole && progress.count + events.labels_written == n && std::fabs(total - 0.125 * double(n)) < 1e-12 &&
         events.written > 0;
}

} // namespace

int main() {
  mollis::workspace workspace;
  const bool good[] = {vortices(workspace), turning(workspace), blobs(workspace), coalescence(workspace)};
  return good[0] && good[1] && good[2] && good[3] ? 0 : 1;
}
