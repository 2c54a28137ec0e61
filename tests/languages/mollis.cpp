/* Calls every function of include/mollis.hpp, in its forms with and without exceptions. The result is the number of failed checks. */
#include "mollis.hpp"

#if defined(MOLLIS_HPP_ABI) || defined(MOLLIS_HPP_SCALAR)
#error "a macro is left"
#endif

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <vector>
#if __has_include(<span>) && __cplusplus >= 202002L
#include <span>
#define SPAN
#endif

/* ------------------------------------------------------------------ checks -------------------------------------------------------------- */

static int failed = 0, passed = 0;

static void expect(bool good, const char *what) {
  good ? ++passed : ++failed;
  if (!good) std::fprintf(stderr, "failed: %s\n", what);
}
#define EXPECT(condition) expect((condition) ? true : false, #condition)

/* Memory that is refused on request. */
static bool no_memory = false;

void *operator new(std::size_t bytes, std::align_val_t, const std::nothrow_t &) noexcept {
  return no_memory ? nullptr : std::aligned_alloc(MOLLIS_ALIGN, (bytes + MOLLIS_ALIGN - 1) / MOLLIS_ALIGN * MOLLIS_ALIGN);
}
void operator delete(void *bytes, std::align_val_t) noexcept { std::free(bytes); }

/* Whether a call in both forms ends with this status, and leaves the outputs alone. `body` gets where errors go. */
template <class Body> static mollis::result refused(mollis_status status, Body body) {
  mollis::result result;
  body(result);
  EXPECT(result.status == status && !result && result.text() != nullptr);
  if (result.status != status) std::fprintf(stderr, "  status %d (%s), not %d\n", result.status, result.text(), status);
#ifdef __cpp_exceptions
  bool thrown = false;
  try {
    body(mollis::errors());
  } catch (const mollis::error &error) {
    thrown = error.status() == status && error.first_bad() == result.first_bad && error.bytes_needed() == result.bytes_needed;
    thrown = thrown && std::string(error.what()).find(mollis_status_text(status)) == 0;
  }
  EXPECT(thrown);
#endif
  return result;
}

#ifdef __cpp_exceptions
/* Whether a call in both forms passes on the exception that a function of the program throws. */
struct mine {
  int number;
};
template <class Body> static void throws(int number, Body body) {
  int caught = 0;
  mollis::result result;
  body(result);
  EXPECT(result.status == mollis::status_thrown && result.exception);
  try {
    if (result.exception) std::rethrow_exception(result.exception);
  } catch (const mine &thrown) {
    caught = thrown.number;
  }
  EXPECT(caught == number);
  caught = 0;
  try {
    body(mollis::errors());
  } catch (const mine &thrown) {
    caught = thrown.number;
  }
  EXPECT(caught == number);
}
#endif

template <class T> static bool near(T a, T b, double tolerance) {
  return std::fabs(static_cast<double>(a) - static_cast<double>(b)) <= tolerance;
}
template <class T> static double tolerance() { return std::is_same_v<T, float> ? 2e-5 : 1e-12; }

/* --------------------------------------------------------- what must not compile --------------------------------------------------------- */

using doubles = std::vector<double>;
using places = std::vector<std::array<double, 2>>;
static_assert(std::is_constructible_v<mollis::points<const double, 2>, const places &>);
static_assert(std::is_constructible_v<mollis::points<double, 2>, places &>);
static_assert(!std::is_constructible_v<mollis::points<double, 2>, const places &>, "an output is written");
static_assert(!std::is_constructible_v<mollis::column<double>, const doubles &>);
static_assert(!std::is_constructible_v<mollis::points<double, 3>, places &>, "another dimension");
static_assert(!std::is_constructible_v<mollis::points<float, 2>, places &>, "another scalar");
static_assert(!std::is_constructible_v<mollis::points<double, 3>, std::vector<doubles> &>, "no array");
static_assert(std::is_constructible_v<mollis::points<const double, 2>, mollis::points<double, 2>>);
static_assert(!std::is_constructible_v<mollis::points<double, 2>, mollis::points<const double, 2>>);
static_assert(!std::is_constructible_v<mollis::column<double>, mollis::column<const double>>);
static_assert(!std::is_convertible_v<std::mt19937, mollis::generator> &&
                  std::is_convertible_v<std::mt19937 &, mollis::generator>,
              "a temporary");
struct caller {
  bool operator()() { return false; }
};
static_assert(!std::is_convertible_v<caller, mollis::function_ref<bool()>> &&
              std::is_convertible_v<caller &, mollis::function_ref<bool()>>);
static_assert(std::is_nothrow_move_constructible_v<mollis::kernel<double, 2>> &&
              std::is_copy_constructible_v<mollis::kernel<double, 2>>);
static_assert(std::is_nothrow_move_assignable_v<mollis::workspace>);

/* --------------------------------------------------------------- layouts ---------------------------------------------------------------- */

struct body {
  int id;
  double x[2];
  std::array<double, 2> velocity;
  double circulation, core, px, py;
};

/* Sums over the same vortices in every layout are the same bits. */
static void layouts() {
  constexpr std::size_t n = 37;
  places x(n), want(n), got(n);
  doubles mass(n), core(n), flat(2 * n), px(n), py(n), potential(n), other(n);
  std::vector<body> bodies(n);
  double array[n][2];
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = {std::sin(1.3 * double(i)), std::cos(2.1 * double(i))};
    mass[i] = 1.0 + 0.1 * double(i);
    core[i] = 0.1 + 0.01 * double(i);
    for (std::size_t k = 0; k < 2; ++k) flat[2 * i + k] = array[i][k] = x[i][k];
    px[i] = x[i][0];
    py[i] = x[i][1];
    bodies[i] = {int(i), {px[i], py[i]}, {}, mass[i], core[i], px[i], py[i]};
  }
  const mollis::kernel<double, 2> kernel(mollis::newtonian(), mollis::gaussian(), 0.1);
  mollis::workspace workspace;
  mollis::field(kernel, {x, mass, core}, {potential, want}, workspace);
  EXPECT(want[3][0] != 0);
  const std::vector<body> &fixed = bodies;
  const std::array<double, 2> *pointer = x.data();
  const mollis::sources<double, 2> sources[] = {
      {x, mass, core},
      {array, mass, core},
      {{array, n}, {mass.data(), n}, core},
      {{pointer, n}, mass, core},
      {flat, mass, core},
      {{flat.data(), n}, mass, core},
      {{{px.data(), py.data()}, n}, mass, core},
      {{{&flat[0], &flat[1]}, n, 2 * sizeof(double)}, mass, core},
      {{fixed, &body::x}, {fixed, &body::circulation}, {bodies, &body::core}},
      {{bodies.data(), n, &body::x}, {bodies.data(), n, &body::circulation}, {fixed.data(), n, &body::core}},
      {{bodies, &body::px, &body::py}, {bodies, &body::circulation}, core},
      {{fixed.data(), n, &body::px, &body::py}, mass, {&bodies[0].core, n, sizeof(body)}},
      {{&bodies[0].px, n, sizeof(body)}, {&bodies[0].circulation, n, sizeof(body)}, core},
#ifdef SPAN
      {std::span(x), std::span<const double>(mass), std::span(core)},
#endif
  };
  for (const auto &from : sources) {
    mollis::field(kernel, from, {other, got}, workspace);
    EXPECT(got == want && other == potential);
    got.assign(n, {});
    mollis::field(kernel, from, x, {{}, got}, workspace);
    EXPECT(got == want);
  }
  const mollis::outputs<double, 2> outputs[] = {{{}, {bodies, &body::velocity}},
                                                {{}, {&bodies[0].velocity[0], n, sizeof(body)}}};
  for (const auto &to : outputs) {
    for (auto &one : bodies) one.velocity = {};
    mollis::field(kernel, {x, mass, core}, to, workspace);
    bool same = true;
    for (std::size_t i = 0; i < n; ++i) same = same && bodies[i].velocity == want[i];
    EXPECT(same);
  }
  got.assign(n, {});
  doubles gx(n), gy(n);
  mollis::field(kernel, {x, mass, core}, {{}, {{gx.data(), gy.data()}, n}}, workspace);
  EXPECT(gx[5] == want[5][0] && gy[5] == want[5][1]);

  /* Views of nothing. */
  places none;
  doubles nothing;
  mollis::field(kernel, {none, nothing}, {nothing}, workspace);
  mollis::field(kernel, {x, mass}, none, {nothing, none}, workspace);

  /* Lengths and strides that do not fit. */
  using mollis::errors;
  auto with = [&](const mollis::sources<double, 2> &from, const mollis::outputs<double, 2> &to) {
    return [&kernel, &workspace, from, to](errors e) { mollis::field(kernel, from, to, workspace, {}, e); };
  };
  doubles short_one(n - 1), odd(2 * n + 1);
  got.assign(n, {1.0, 2.0});
  const places before = got;
  refused(MOLLIS_ERR_LENGTH_MISMATCH, with({x, short_one}, {{}, got}));
  refused(MOLLIS_ERR_LENGTH_MISMATCH, with({x, mass, short_one}, {{}, got}));
  refused(MOLLIS_ERR_LENGTH_MISMATCH, with({x, mass}, {short_one, got}));
  refused(MOLLIS_ERR_LENGTH_MISMATCH, with({odd, mass}, {{}, got}));
  refused(MOLLIS_ERR_LENGTH_MISMATCH, with({x, mass}, {nothing, got}));
  refused(MOLLIS_ERR_MISALIGNED, with({{&bodies[0].px, n, sizeof(body) - 4}, mass}, {{}, got}));
  refused(MOLLIS_ERR_NULL_POINTER, with({x, {}}, {{}, got}));
  refused(MOLLIS_ERR_OVERLAP, with({x, mass}, {{}, x}));
  EXPECT(got == before);
}

/* ------------------------------------------------- every scalar in every dimension ------------------------------------------------------ */

template <class T, std::size_t D> static void sums() {
  using point = std::array<T, D>;
  constexpr std::size_t n = 24;
  const T delta = static_cast<T>(0.5);
  std::vector<point> x(n), at(5), gradient(n);
  std::vector<T> mass(n), potential(n), laplacian(n), value(1), factor(1), lap(1);
  std::mt19937 engine(7);
  std::uniform_real_distribution<T> uniform(-1, 1);
  for (std::size_t i = 0; i < n; ++i) {
    for (T &coordinate : x[i]) coordinate = uniform(engine);
    mass[i] = uniform(engine);
  }
  for (point &place : at)
    for (T &coordinate : place) coordinate = uniform(engine);
  const mollis::kernel<T, D> kernel({mollis::newtonian(1.0), mollis::exponential(-0.5, 2.0)}, mollis::compact(2, 4), delta);
  mollis::workspace workspace;
  mollis::field_options options;
  mollis_field_counts counts{};
  options.counts = &counts;
  mollis::field(kernel, {x, mass}, {potential, gradient, laplacian}, workspace, options);
  EXPECT(counts.pairs == n * n);

  /* The same from the kernel's values. */
  double worst = 0;
  for (std::size_t i = 0; i < n; ++i) {
    double u = 0, l = 0, g[D] = {};
    for (std::size_t j = 0; j < n; ++j) {
      double square = 0;
      for (std::size_t k = 0; k < D; ++k) square += std::pow(static_cast<double>(x[i][k]) - static_cast<double>(x[j][k]), 2);
      const std::vector<T> r(1, static_cast<T>(std::sqrt(square)));
      mollis::evaluate(kernel, r, {value, factor, lap});
      const double m = static_cast<double>(mass[j]);
      u += m * static_cast<double>(value[0]);
      l += m * static_cast<double>(lap[0]);
      for (std::size_t k = 0; k < D; ++k)
        g[k] += m * static_cast<double>(factor[0]) * (static_cast<double>(x[i][k]) - static_cast<double>(x[j][k]));
    }
    worst =
        std::max({worst, std::fabs(u - static_cast<double>(potential[i])), std::fabs(l - static_cast<double>(laplacian[i]))});
    for (std::size_t k = 0; k < D; ++k) worst = std::max(worst, std::fabs(g[k] - static_cast<double>(gradient[i][k])));
  }
  EXPECT(worst <= 10 * tolerance<T>());

  /* Second derivatives: in an array, in structures, and by an address. */
  using matrix = std::array<std::array<T, D>, D>;
  struct star {
    T before;
    T tide[D][D];
    T after;
  };
  std::vector<matrix> tides(n);
  std::vector<star> stars(n, star{1, {}, 2});
  std::vector<T> flat(n * D * D);
  for (const mollis::matrices<T, D> &to :
       {mollis::matrices<T, D>(tides), mollis::matrices<T, D>(stars, &star::tide), mollis::matrices<T, D>(flat.data(), n)}) {
    mollis::outputs<T, D> out;
    out.hessian = to;
    mollis::field(kernel, {x, mass}, out, workspace);
  }
  for (std::size_t i = 0; i < n; ++i) {
    T trace = 0;
    for (std::size_t k = 0; k < D; ++k) {
      trace += tides[i][k][k];
      for (std::size_t j = 0; j < D; ++j)
        EXPECT(near(stars[i].tide[k][j], tides[i][k][j], 0) && near(flat[(i * D + k) * D + j], tides[i][j][k], 0));
    }
    EXPECT(near(trace, laplacian[i], 10 * tolerance<T>()) && near(stars[i].before, T(1), 0) && near(stars[i].after, T(2), 0));
  }
  mollis::result wrong;
  mollis::outputs<T, D> few;
  few.hessian = {flat.data(), n - 1};
  mollis::field(kernel, {x, mass}, few, workspace, {}, wrong);
  EXPECT(wrong.status == MOLLIS_ERR_LENGTH_MISMATCH);

  /* A core radius for each pair: forces add up to zero. */
  const mollis::kernel<T, D> soft(mollis::newtonian(1.0), mollis::plummer(), delta);
  std::vector<T> radii(n), of_targets(at.size(), delta), there_too(at.size());
  for (std::size_t i = 0; i < n; ++i) radii[i] = static_cast<T>(0.2 + 0.02 * static_cast<double>(i));
  mollis::sources<T, D> each{x, mass, radii};
  mollis::field_options pairs;
  pairs.pair_radius = MOLLIS_PAIR_RADIUS_MEAN;
  mollis::field(soft, each, {{}, gradient}, workspace, pairs);
  for (std::size_t k = 0; k < D; ++k) {
    T sum = 0;
    for (std::size_t i = 0; i < n; ++i) sum += mass[i] * gradient[i][k];
    EXPECT(near(sum, T(0), 10 * tolerance<T>()));
  }
  mollis::field(soft, each, at, {there_too}, workspace, pairs, wrong);
  EXPECT(wrong.status == MOLLIS_ERR_LENGTH_MISMATCH);
  each.target_radii = of_targets;
  mollis::field(soft, each, at, {there_too}, workspace, pairs, wrong);
  EXPECT(wrong.status == MOLLIS_OK);

  /* At targets, multiplied and added. */
  std::vector<T> there(at.size(), 1), once(at.size());
  mollis::field(kernel, {x, mass}, at, {once}, workspace);
  mollis::outputs<T, D> more{there};
  more.factor = -2;
  more.add = true;
  mollis::field(kernel, {x, mass}, at, more, workspace);
  for (std::size_t i = 0; i < at.size(); ++i) EXPECT(near(there[i], 1 - 2 * once[i], tolerance<T>()));
  EXPECT(mollis::field_text(kernel, {x, mass}, at, {once}).find("direct") != std::string::npos);
  mollis::result result;
  EXPECT(mollis::field_text(mollis::kernel<T, D>(), {x, mass}, at, {once}, {}, result).empty() && !result);

  /* Without a mollifier. */
  const mollis::kernel<T, D> singular({mollis::power(1.0, 2.0), mollis::newtonian(-1.0)}, mollis::none());
  mollis::field(singular, {x, mass}, {{}, gradient}, workspace);
  EXPECT(std::isfinite(gradient[0][0]));
  const mollis::kernel<T, D> yukawa(mollis::screened(1.0, 1.5), mollis::gaussian(4), delta);
  mollis::field(yukawa, {x, mass}, {potential}, workspace);
  EXPECT(std::isfinite(potential[0]));

  /* An own kernel that is the Newtonian one. */
  auto same = [](double r) {
    const double pi = std::acos(-1.0), surface = D == 1 ? 2 : D == 2 ? 2 * pi : 4 * pi;
    const double k = D == 1 ? r / 2 : D == 2 ? std::log(r) / surface : -1 / (surface * r);
    return std::array<double, 3>{k, 1 / (surface * std::pow(r, double(D))), 0.0};
  };
  std::array<double, 3> reached{-1, -1, -1};
  mollis::radial own(same, 10.0);
  own.reached = &reached;
  own.knots = {0.25, 0.5};
  std::vector<T> first(n), second(n);
  mollis::field(mollis::kernel<T, D>(own), {x, mass}, {first}, workspace);
  mollis::field(mollis::kernel<T, D>(mollis::newtonian(), mollis::none()), {x, mass}, {second}, workspace);
  for (std::size_t i = 0; i < n; ++i) EXPECT(near(first[i], second[i], 20 * tolerance<T>()));
  EXPECT(reached[0] >= 0 && reached[1] >= 0 && reached[2] >= 0);
  mollis::field(mollis::kernel<T, D>(mollis::newtonian(-1.0), own), {x, mass}, {first}, workspace);
  for (std::size_t i = 0; i < n; ++i) EXPECT(near(first[i], T(0), 20 * tolerance<T>()));

  /* Diagnostics. */
  const auto moments = mollis::moments<T, D>(x, mass);
  double total = 0, absolute = 0, centre = 0, about = 0;
  for (std::size_t i = 0; i < n; ++i) {
    total += static_cast<double>(mass[i]);
    absolute += std::fabs(static_cast<double>(mass[i]));
    centre += static_cast<double>(mass[i]) * static_cast<double>(x[i][0]);
  }
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 0; k < D; ++k)
      about +=
          static_cast<double>(mass[i]) * std::pow(static_cast<double>(x[i][k]) - static_cast<double>(moments.centre[k]), 2);
  EXPECT(near(static_cast<double>(moments.mass), total, tolerance<T>()) &&
         near(static_cast<double>(moments.absolute_mass), absolute, tolerance<T>()));
  EXPECT(near(static_cast<double>(moments.centre[0]), centre / total, 20 * tolerance<T>()));
  EXPECT(near(static_cast<double>(moments.second), about, 20 * tolerance<T>()));
  const T here = mollis::stable_step(kernel, x, mass);
  const T anywhere = mollis::stable_step_anywhere(kernel, moments.absolute_mass, T(4));
  EXPECT(here > 0 && anywhere > 0 && anywhere <= here);
  std::vector<T> ones(n, 1), density(n);
  EXPECT(near((mollis::overlap<T, D>(delta, ones, ones)), delta, tolerance<T>()));
  EXPECT(near((mollis::norm<T>(ones, T(0.5), 1.0)), T(n) / 2, tolerance<T>()));
  EXPECT((mollis::distance_norm<T, D>(x, x, T(1), 2.0)) == 0);
  std::vector<T> enclosed(1), density_slope(1), hessian(1);
  mollis::evaluate<T, D>(mollis::compact(2, 4), delta, std::vector<T>(1, T(1)),
                         {value, density_slope, lap, factor, hessian, enclosed});
  EXPECT(value[0] == 0 && enclosed[0] == 1);

  /* The blob method. */
  std::vector<point> moved = x, tracer(x.begin(), x.begin() + 3), velocity(n);
  std::vector<T> positive(n), rho(n, 1), tracer_rho(3, 1), divergence(n);
  for (std::size_t i = 0; i < n; ++i) positive[i] = std::fabs(mass[i]);
  mollis::particles<T, D> blobs{moved, positive, rho, velocity, divergence};
  std::size_t calls = 0;
  bool seen = true;
  auto after = [&](std::size_t steps, mollis::points<const T, D> now, mollis::column<const T> densities) {
    ++calls;
    seen = seen && steps == calls && now.size() == n && densities.size() == n && now.axis(0)[0] != x[0][0];
    return false;
  };
  mollis::blob_options<T, D> blob_options;
  blob_options.watch_energy = true;
  blob_options.after_step = after;
  const mollis::kernel<T, D> attraction(mollis::newtonian(1.0), mollis::compact(2, 4), delta);
  const mollis_blob_report report =
      mollis::blob_step(attraction, blobs, {tracer, {}, tracer_rho}, 0.01, 5, workspace, blob_options);
  EXPECT(report.steps == 5 && calls == 5 && seen && report.energy_last < report.energy_first && velocity[0][0] != 0);
  for (std::size_t k = 0; k < 3; ++k) EXPECT(near(tracer[k][0], moved[k][0], 10 * tolerance<T>()));

  /* Refusals. */
  const T bad = std::numeric_limits<T>::quiet_NaN();
  std::vector<point> holes = x;
  holes[7][D - 1] = bad;
  using mollis::errors;
  EXPECT(refused(MOLLIS_ERR_NOT_FINITE, [&](errors e) {
           mollis::field(kernel, {holes, mass}, {potential}, workspace, {}, e);
         }).first_bad == 7);
  EXPECT(refused(MOLLIS_ERR_NOT_FINITE, [&](errors e) {
           mollis::field(kernel, {x, mass}, holes, {potential}, workspace, {}, e);
         }).first_bad == n + 7);
  EXPECT(refused(MOLLIS_ERR_NOT_FINITE, [&](errors e) { mollis::stable_step(kernel, holes, mass, e); }).first_bad == 7);
  std::vector<T> bad_mass = mass;
  bad_mass[9] = bad;
  EXPECT(refused(MOLLIS_ERR_NOT_FINITE, [&](errors e) { mollis::stable_step(kernel, x, bad_mass, e); }).first_bad == 9);
  EXPECT(refused(MOLLIS_ERR_NOT_FINITE, [&](errors e) { mollis::evaluate(kernel, bad_mass, {first}, e); }).first_bad == 9);
  EXPECT(refused(MOLLIS_ERR_NOT_FINITE, [&](errors e) {
           mollis::evaluate<T, D>(mollis::gaussian(), delta, bad_mass, {first}, e);
         }).first_bad == 9);
  blobs.positions = holes;
  EXPECT(refused(MOLLIS_ERR_NOT_FINITE, [&](errors e) {
           mollis::blob_step(kernel, blobs, {}, 0.01, 5, workspace, {}, e);
         }).first_bad == 7);
  blobs.positions = moved;
  refused(MOLLIS_ERR_NOT_PREPARED, [&](errors e) {
    mollis::field(mollis::kernel<T, D>(), {x, mass}, {potential}, workspace, {}, e);
  });
  refused(MOLLIS_ERR_TIME_STEP, [&](errors e) { mollis::blob_step(kernel, blobs, {}, -0.01, 5, workspace, {}, e); });
  refused(MOLLIS_ERR_LENGTH_MISMATCH, [&](errors e) {
    mollis::blob_step(kernel, blobs, {tracer, {}, rho}, 0.01, 5, workspace, {}, e);
  });
  refused(MOLLIS_ERR_LENGTH_MISMATCH, [&](errors e) { mollis::moments<T, D>(x, enclosed, e); });
  refused(MOLLIS_ERR_LENGTH_MISMATCH, [&](errors e) { mollis::overlap<T, D>(delta, ones, enclosed, e); });
  refused(MOLLIS_ERR_LENGTH_MISMATCH, [&](errors e) { mollis::distance_norm<T, D>(x, tracer, T(1), 1.0, e); });
  refused(MOLLIS_ERR_UNSUPPORTED, [&](errors e) { mollis::norm<T>({ones.data(), n / 2, 2 * sizeof(T)}, T(1), 1.0, e); });
  refused(MOLLIS_ERR_OUT_OF_DOMAIN, [&](errors e) { mollis::norm<T>(ones, T(-1), 1.0, e); });
  refused(MOLLIS_ERR_OUT_OF_DOMAIN, [&](errors e) { mollis::stable_step_anywhere(kernel, T(-1), T(1), e); });
  refused(MOLLIS_ERR_DELTA, [&](errors e) { mollis::kernel<T, D>(mollis::newtonian(), mollis::compact(2, 4), T(-1), e); });
  refused(MOLLIS_ERR_ORDER, [&](errors e) { mollis::kernel<T, D>(mollis::newtonian(), mollis::compact(3, 4), delta, e); });
  refused(MOLLIS_ERR_KERNEL_TERMS,
          [&](errors e) { mollis::kernel<T, D>(std::vector<mollis::term>(9, mollis::newtonian()), mollis::none(), T(0), e); });
  refused(MOLLIS_ERR_KERNEL_TERMS, [&](errors e) { mollis::kernel<T, D>({}, mollis::none(), T(0), e); });
}

/* ------------------------------------------------------- what is in some dimensions ------------------------------------------------------ */

/* An own kernel of two pieces, with all that may be said about it. */
/* What is essential for a far box acts there as all sources do; for their own box it is all of them. */
template <class T, std::size_t D> static void essentials() {
  using point = std::array<T, D>;
  constexpr std::size_t n = 3000;
  const double tolerance = std::is_same_v<T, float> ? 1e-4 : 1e-6;
  std::vector<point> x(n), at(20);
  std::vector<T> mass(n, T(1) / T(n));
  std::mt19937 engine(3);
  std::uniform_real_distribution<T> uniform(0, 1);
  for (point &place : x)
    for (T &coordinate : place) coordinate = uniform(engine);
  for (point &place : at)
    for (T &coordinate : place) coordinate = 9 + uniform(engine);
  std::vector<point> corners(4);
  corners[0].fill(9);
  corners[1].fill(10);
  corners[2].fill(0);
  corners[3].fill(1);
  const mollis::kernel<T, D> kernel(mollis::newtonian(1.0), mollis::compact(2, 4), static_cast<T>(0.05));
  mollis::workspace workspace;
  std::vector<std::uint64_t> starts(3), again(3);
  mollis::essential(kernel, {x, mass}, corners, tolerance, starts, {}, workspace);
  EXPECT(starts[0] == 0 && starts[1] > 0 && starts[1] < n / 4 && starts[2] - starts[1] == n);
  std::vector<point> y(starts[2]);
  std::vector<T> m(starts[2]);
  std::vector<std::uint64_t> origins(starts[2]);
  mollis::essential(kernel, {x, mass}, corners, tolerance, again, {y, m, origins}, workspace);
  EXPECT(again == starts);
  for (std::size_t i = starts[1]; i < starts[2]; ++i) EXPECT(y[i] == x[origins[i]]);

  std::vector<T> all(at.size()), few(at.size());
  mollis::field(kernel, {x, mass}, at, {all}, workspace);
  mollis::field(kernel, {{y.data(), starts[1]}, {m.data(), starts[1]}}, at, {few}, workspace);
  for (std::size_t i = 0; i < at.size(); ++i)
    EXPECT(near(all[i], few[i], 10 * tolerance * (1 + std::fabs(static_cast<double>(all[i])))));

  /* Refusals. */
  const auto ask = [&](const std::vector<point> &boxes, double error, mollis::column<std::uint64_t> begin,
                       const mollis::essential_outputs<T, D> &out, mollis::workspace &in) {
    return [&, boxes, error, begin, out](mollis::errors e) {
      mollis::essential(kernel, {x, mass}, boxes, error, begin, out, in, {}, e);
    };
  };
  const std::vector<point> odd(corners.begin(), corners.begin() + 3);
  refused(MOLLIS_ERR_LENGTH_MISMATCH, ask(odd, tolerance, starts, {}, workspace));
  refused(MOLLIS_ERR_LENGTH_MISMATCH, ask(corners, tolerance, {starts.data(), 2}, {}, workspace));
  refused(MOLLIS_ERR_LENGTH_MISMATCH, ask(corners, tolerance, starts, {y, {m.data(), 1}}, workspace));
  refused(MOLLIS_ERR_UNSUPPORTED, ask(corners, tolerance, {starts.data(), 3, 16}, {}, workspace));
  refused(MOLLIS_ERR_OUT_OF_DOMAIN, ask(corners, 0.0, starts, {}, workspace));
  std::fill(again.begin(), again.end(), 0);
  refused(MOLLIS_ERR_NO_ROOM, ask(corners, tolerance, again, {{y.data(), 1}, {m.data(), 1}}, workspace));
  EXPECT(again == starts);
  mollis::workspace none(nullptr, 0);
  EXPECT(refused(MOLLIS_ERR_WORKSPACE_TOO_SMALL, ask(corners, tolerance, starts, {}, none)).bytes_needed > 0);
  x[7][0] = std::numeric_limits<T>::quiet_NaN();
  EXPECT(refused(MOLLIS_ERR_NOT_FINITE, ask(corners, tolerance, starts, {}, workspace)).first_bad == 7);
}

static void own_kernels() {
  auto pieces = [](double r) {
    return r < 0.6 ? std::array<double, 3>{r * r / 2, 1, 2} : std::array<double, 3>{0.6 * r - 0.18, 0.6 / r, 0.6 / r};
  };
  const doubles at{0.25, 0.75};
  doubles value(2);
  mollis::radial own(pieces, 2.0);
  const auto prepare = [&own](mollis::errors e) { mollis::kernel<double, 2>(own, mollis::none(), 0, e); };
  refused(MOLLIS_ERR_KERNEL_FIT, prepare);
  own.knots = {0.6};
  own.coefficient = -2;
  mollis::evaluate(mollis::kernel<double, 2>(own), at, {value});
  EXPECT(near(value[0], -0.0625, 1e-10) && near(value[1], -0.54, 1e-10));
  own.knots = {0.6, 0.25};
  refused(MOLLIS_ERR_KERNEL_KNOTS, prepare);
  own.knots = doubles(9, 0.5);
  refused(MOLLIS_ERR_KERNEL_KNOTS, prepare);
  own.knots = {};
  own.tolerance = std::numeric_limits<double>::infinity();
  mollis::evaluate(mollis::kernel<double, 2>(own), at, {value});
  EXPECT(near(value[0], -0.0625, 0.1));
  own.least = 3;
  refused(MOLLIS_ERR_OUT_OF_DOMAIN, prepare);
  own.reach = 0;
  refused(MOLLIS_ERR_KERNEL_REACH, prepare);
}

/* Kernels are values. */
static void kernels() {
  const doubles r{0.01, 0.3, 2.0};
  doubles a(3), b(3);
  mollis::kernel<double, 2> kernel(mollis::newtonian(), mollis::plummer(), 0.1), copy = kernel;
  mollis::evaluate(kernel, r, {a});
  EXPECT(copy.data() != kernel.data() && copy.size() == kernel.size());
  EXPECT(reinterpret_cast<std::uintptr_t>(kernel.data()) % MOLLIS_ALIGN == 0);
  const mollis::kernel<double, 2> moved = std::move(copy);
  mollis::evaluate(moved, r, {b});
  EXPECT(a == b && copy.size() == 0 && copy.data() == nullptr);
  copy = kernel;
  kernel = {mollis::newtonian(), mollis::algebraic(), 0.1};
  mollis::evaluate(copy, r, {b});
  EXPECT(a == b);
  mollis::evaluate(kernel, r, {b});
  EXPECT(a != b);
  for (const mollis::mollifier softening :
       {mollis::none(), mollis::vatistas(), mollis::gaussian(6), mollis::compact(8, 9), mollis::richardson(6, 4)})
    mollis::evaluate(mollis::kernel<double, 2>(mollis::newtonian(), softening, 0.1), r, {b});
  refused(MOLLIS_ERR_DIMENSION,
          [](mollis::errors e) { mollis::kernel<double, 3>(mollis::newtonian(), mollis::vatistas(), 0.1, e); });

  mollis::result result;
  EXPECT((mollis::kernel<double, 2>(mollis::newtonian(), mollis::compact(2, 4), -1, result).size()) == 0);

  no_memory = true;
  const mollis::kernel<double, 2> none(mollis::newtonian(), mollis::none(), 0, result);
  EXPECT(result.status == mollis::status_no_memory && result.bytes_needed > 0 && none.size() == 0 &&
         std::string(result.text()) == "out of memory");
  mollis::workspace workspace;
  places x(3);
  doubles mass(3, 1.0);
  mollis::field(moved, {x, mass}, {a}, workspace, {}, result);
  EXPECT(result.status == mollis::status_no_memory && result.bytes_needed > 0);
#ifdef __cpp_exceptions
  int caught = 0;
  for (int k = 0; k < 2; ++k) {
    try {
      if (k == 0) mollis::field(moved, {x, mass}, {a}, workspace);
      if (k == 1) static_cast<void>(mollis::kernel<double, 2>(moved));
    } catch (const std::bad_alloc &) {
      ++caught;
    }
  }
  EXPECT(caught == 2);
#endif
  no_memory = false;
  mollis::field(moved, {x, mass}, {a}, workspace, {}, result);
  EXPECT(result);
}

/* Workspaces grow, or are the program's. */
static void workspaces() {
  places x(50), gradient(50);
  doubles mass(50, 1.0);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = {double(i), double(i * i)};
  const mollis::kernel<double, 2> kernel(mollis::newtonian(), mollis::compact(2, 4), 0.1);
  unsigned char buffer[8192];
  mollis::workspace tiny(buffer, 7), none(nullptr, 0), grows;
  const mollis::result short_one = refused(MOLLIS_ERR_WORKSPACE_TOO_SMALL, [&](mollis::errors e) {
    mollis::field(kernel, {x, mass}, {{}, gradient}, tiny, {}, e);
  });
  refused(MOLLIS_ERR_WORKSPACE_TOO_SMALL, [&](mollis::errors e) {
    mollis::field(kernel, {x, mass}, {{}, gradient}, none, {}, e);
  });
  EXPECT(short_one.bytes_needed > 7 && short_one.bytes_needed < sizeof buffer && gradient[1][0] == 0);
  mollis::workspace fixed(buffer, short_one.bytes_needed);
  mollis::field(kernel, {x, mass}, {{}, gradient}, fixed);
  places again(50);
  mollis::field(kernel, {x, mass}, {{}, again}, grows);
  EXPECT(again == gradient && grows.size() >= short_one.bytes_needed);
  const void *before = grows.data();
  mollis::field(kernel, {x, mass}, {{}, again}, grows);
  EXPECT(grows.data() == before);
}

/* Vortex elements in space, and combinations in the plane. */
static void vortices() {
  const std::vector<std::array<double, 3>> x{{0, 0, 0}}, strength{{0, 0, 2}}, at{{0.5, 0, 0}};
  std::vector<std::array<double, 3>> velocity(1);
  mollis::workspace workspace;
  mollis::sources<double, 3> from{x};
  from.strengths = strength;
  mollis::field(mollis::kernel<double, 3>(mollis::newtonian(), mollis::compact(2, 4), 0.1), from, at, {{}, velocity},
                workspace);
  const double pi = std::acos(-1.0);
  EXPECT(velocity[0][0] == 0 && near(std::fabs(velocity[0][1]), 2 / (4 * pi * 0.25), 1e-14) && velocity[0][2] == 0);
  mollis::field_options options;
  options.combination[0] = 0;
  options.combination[1] = 1;
  const places x2{{0, 0}}, at2{{0.5, 0}};
  places turn(1);
  const doubles circulation{2.0};
  mollis::field(mollis::kernel<double, 2>(mollis::newtonian(), mollis::compact(2, 4), 0.1), {x2, circulation}, at2, {{}, turn},
                workspace, options);
  EXPECT(turn[0][0] == 0 && near(turn[0][1], 2 / (2 * pi * 0.5), 1e-14));

  /* Two of them turn about their centre a quarter in (pi r)^2 / (2 m), in steps of the blob method. */
  places pair{{-0.5, 0}, {0.5, 0}};
  const doubles equal{2.0, 2.0};
  mollis::blob_options<double, 2> turning;
  turning.combination[0] = 0;
  turning.combination[1] = -1;
  turning.watch_energy = true;
  const mollis_blob_report told = mollis::blob_step(mollis::kernel<double, 2>(mollis::newtonian(), mollis::compact(2, 4), 0.1),
                                                    {pair, equal}, {}, pi * pi / 4 / 50, 50, workspace, turning);
  EXPECT(told.steps == 50 && near(pair[1][0], 0.0, 1e-5) && near(pair[1][1], 0.5, 1e-5));
}

/* Two blobs with m = 2 spread at 2 nu m |phi'|; a kernel of coefficient 0 adds no force. */
static void diffusing() {
  std::vector<std::array<double, 1>> x{{0}, {0.5}}, velocity(2);
  const doubles mass{1.0, 1.0};
  mollis::particles<double, 1> blobs{x, mass};
  blobs.velocity = velocity;
  mollis::blob_options<double, 1> options;
  options.diffusion = 0.5;
  options.diffusion_exponent = 2;
  options.diffusion_length = 1;
  options.diffusion_mollifier = mollis::compact(2, 4);
  mollis::workspace workspace;
  mollis::blob_step(mollis::kernel<double, 1>(mollis::newtonian(0), mollis::compact(2, 4), 1), blobs, {}, 0.1, 0, workspace, options);
  /* phi = 315/256 (1 - x^2)^4, so -phi'(1/2) = 315/256 4 (3/4)^3. */
  const double speed = 315.0 / 256 * 4 * 27 / 64;
  EXPECT(near(velocity[0][0], -speed, 1e-13) && near(velocity[1][0], speed, 1e-13));
}

/* A mesh. */
template <class T> static void meshes() {
  constexpr std::size_t n = 100, nodes = 17 * 17;
  std::vector<std::array<T, 2>> x(n), gradient(n), node_gradient(nodes);
  std::vector<T> mass(n, T(0.5)), node_mass(nodes), node_potential(nodes);
  for (std::size_t i = 0; i < n; ++i) x[i] = {static_cast<T>(std::sin(double(i))), static_cast<T>(std::cos(1.7 * double(i)))};
  x[0] = {3, 0};
  const mollis::mesh mesh = {{-2, -2}, {2, 2}, {16, 16}};
  std::array<T, 3> total{};
  std::uint64_t outside = 0;
  mollis::grid_outputs<T> out;
  out.gradient = gradient;
  out.node_mass = node_mass;
  out.node_potential = node_potential;
  out.node_gradient = node_gradient;
  out.total = &total;
  out.outside = &outside;
  mollis::workspace workspace;
  mollis::grid_options options;
  options.order = 4;
  mollis::grid<T>(mesh, {x, mass}, {}, out, workspace, options);
  const auto moments = mollis::moments<T, 2>(x, mass);
  EXPECT(near(total[0], moments.mass, 10 * tolerance<T>()) && near(total[1], moments.centre[0], 10 * tolerance<T>()) &&
         outside == 1);
  EXPECT(gradient[5][0] != 0 && node_potential[5] != 0 && node_gradient[5][1] != 0);
  double sum = 0;
  for (const T one : node_mass) sum += static_cast<double>(one);
  EXPECT(near(sum, 0.5 * (n - 1), 10 * tolerance<T>()));
  mollis::grid<T>(mesh, {x, mass}, {{}, 0}, {{nullptr, 0}}, workspace);
  const mollis::mesh flat = {{-2, -2}, {2, -2}, {16, 16}};
  refused(MOLLIS_ERR_OUT_OF_DOMAIN, [&](mollis::errors e) { mollis::grid<T>(flat, {x, mass}, {}, out, workspace, {}, e); });
  out.node_mass = mass;
  refused(MOLLIS_ERR_LENGTH_MISMATCH, [&](mollis::errors e) { mollis::grid<T>(mesh, {x, mass}, {}, out, workspace, {}, e); });
}

/* Functions of the program: they run, they stop, and what they throw arrives. */
static void callables() {
  constexpr std::size_t n = 3000;
  places x(n), gradient(n), again(n);
  doubles mass(n, 1.0 / n);
  for (std::size_t i = 0; i < n; ++i) x[i] = {std::sin(1.3 * double(i)), std::cos(2.1 * double(i))};
  const mollis::kernel<double, 2> kernel(mollis::newtonian(), mollis::compact(2, 4), 0.1);
  mollis::workspace workspace;
  mollis::field(kernel, {x, mass}, {{}, gradient}, workspace);

  std::size_t ran = 0;
  auto backwards = [&ran](std::size_t tasks, const mollis::task &task) {
    for (std::size_t i = tasks; i-- > 0;) task(i, i % 3);
    ran += tasks;
  };
  mollis::field_options options;
  options.run.executor = {3, backwards};
  options.run.level = MOLLIS_LEVEL_BEST;
  mollis::field(kernel, {x, mass}, {{}, again}, workspace, options);
  EXPECT(ran > 0 && again == gradient);
  auto lazy = [](std::size_t, const mollis::task &) {};
  options.run.executor = {3, lazy};
  refused(MOLLIS_ERR_EXECUTOR, [&](mollis::errors e) { mollis::field(kernel, {x, mass}, {{}, again}, workspace, options, e); });
  for (const std::size_t workers : {std::size_t{0}, std::size_t{1000}}) {
    options.run.executor = {workers, lazy};
    refused(MOLLIS_ERR_OUT_OF_DOMAIN, [&](mollis::errors e) {
      mollis::field(kernel, {x, mass}, {{}, again}, workspace, options, e);
    });
  }
  options.run.executor = {};
  options.run.level = 77;
  refused(MOLLIS_ERR_UNKNOWN_VALUE, [&](mollis::errors e) {
    mollis::field(kernel, {x, mass}, {{}, again}, workspace, options, e);
  });
  options.run.level = MOLLIS_LEVEL_BEST;

  std::size_t asked = 0;
  auto never = [&asked] { return ++asked == 0; };
  options.run.stop = never;
  mollis::field(kernel, {x, mass}, {{}, again}, workspace, options);
  EXPECT(asked > 0);
  auto stop = [] { return true; };
  options.run.stop = stop;
  refused(MOLLIS_ERR_STOPPED, [&](mollis::errors e) { mollis::field(kernel, {x, mass}, {{}, again}, workspace, options, e); });

  mollis::blob_options<double, 2> blob;
  blob.tolerance = -1;
  refused(MOLLIS_ERR_OUT_OF_DOMAIN, [&](mollis::errors e) {
    mollis::blob_step(kernel, {x, mass}, {}, 0.01, 5, workspace, blob, e);
  });
  blob.tolerance = 0;
  auto second = [](std::size_t steps, mollis::points<const double, 2>, mollis::column<const double> density) {
    return steps == 2 && !density.given();
  };
  blob.after_step = second;
  mollis::result result;
  EXPECT(mollis::blob_step(kernel, {x, mass}, {}, 0.01, 5, workspace, blob, result).steps == 2 &&
         result.status == MOLLIS_ERR_STOPPED);

  auto well = [](double r) { return std::array<double, 3>{std::exp(-r), r > 0.1 ? 5.0 : -std::exp(-r) / r, 1.0}; };
  refused(MOLLIS_ERR_KERNEL_FIT,
          [&](mollis::errors e) { mollis::kernel<double, 2>(mollis::radial(well, 2.0), mollis::none(), 0, e); });

#ifdef __cpp_exceptions
  auto throwing_loop = [](std::size_t tasks, const mollis::task &task) {
    for (std::size_t i = 0; i < tasks; ++i) task(i, 0);
    throw mine{1};
  };
  options.run.stop = {};
  options.run.executor = {1, throwing_loop};
  throws(1, [&](mollis::errors e) { mollis::field(kernel, {x, mass}, {{}, again}, workspace, options, e); });
  auto throwing_stop = []() -> bool { throw mine{2}; };
  options.run = {};
  options.run.stop = throwing_stop;
  throws(2, [&](mollis::errors e) { mollis::field(kernel, {x, mass}, {{}, again}, workspace, options, e); });
  auto throwing_step = [](std::size_t, mollis::points<const double, 2>, mollis::column<const double>) -> bool {
    throw mine{3};
  };
  blob.after_step = throwing_step;
  throws(3, [&](mollis::errors e) { mollis::blob_step(kernel, {x, mass}, {}, 0.01, 5, workspace, blob, e); });
  auto throwing_kernel = [](double r) -> std::array<double, 3> {
    if (r < 0.5) throw mine{4};
    return {r, 1 / r, 1 / r};
  };
  throws(4, [&](mollis::errors e) { mollis::kernel<double, 2>(mollis::radial(throwing_kernel, 2.0), mollis::none(), 0, e); });
  bool checked = false;
  try {
    mollis::check(MOLLIS_ERR_DELTA);
  } catch (const mollis::error &error) {
    checked = error.status() == MOLLIS_ERR_DELTA;
  }
  EXPECT(checked);
#endif
  mollis::check(MOLLIS_OK);
  mollis::check(MOLLIS_ERR_DELTA, result);
  EXPECT(result.status == MOLLIS_ERR_DELTA);
}

/* ------------------------------------------------------- coalescing particles ----------------------------------------------------------- */

/* Words of one generator, counted. */
struct counted {
  using result_type = std::uint64_t;
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return UINT64_MAX; }
  result_type operator()() {
    ++drawn;
#ifdef __cpp_exceptions
    if (drawn > limit) throw mine{5};
#endif
    return engine();
  }
  std::mt19937_64 engine{42};
  std::size_t drawn = 0, limit = std::numeric_limits<std::size_t>::max();
};

/* Some bits at a time of another generator's words, the lowest first. */
template <unsigned Bits> struct piecewise {
  using result_type = std::uint32_t;
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return static_cast<result_type>((std::uint64_t{1} << Bits) - 1); }
  result_type operator()() {
    if (left == 0) {
      word = engine();
      left = 64 / Bits;
    }
    --left;
    const auto low = static_cast<result_type>(word & max());
    word >>= Bits;
    return low;
  }
  std::mt19937_64 engine{42};
  std::uint64_t word = 0;
  unsigned left = 0;
};

/* The state of a run. */
template <class T> struct crowd {
  static constexpr std::size_t n = 200;
  std::vector<std::array<T, 2>> x{n};
  std::vector<T> mass = std::vector<T>(n, T(0.125));
  std::vector<std::uint64_t> labels{std::vector<std::uint64_t>(n)};
  std::vector<std::uint32_t> species{std::vector<std::uint32_t>(n, 1)};
  mollis::pks_progress progress{n};
  crowd() {
    for (std::size_t i = 0; i < n; ++i) {
      x[i] = {static_cast<T>(std::sin(1.3 * double(i)) / 2), static_cast<T>(std::cos(2.1 * double(i)) / 2)};
      labels[i] = i;
      species[i] = static_cast<std::uint32_t>(i);
    }
  }
  mollis::pks_particles<T> all() { return {x, mass, labels, species}; }
  bool operator==(const crowd &other) const {
    return x == other.x && mass == other.mass && labels == other.labels && progress.count == other.progress.count;
  }
};

template <class T> static void coalescence() {
  constexpr std::size_t n = crowd<T>::n;
  const mollis::kernel<T, 2> kernel(mollis::newtonian(), mollis::compact(2, 4), T(0.01));
  const mollis::pks_attraction<T> attraction(kernel);
  std::vector<mollis_pks_event> log(n), one(1);
  std::vector<std::uint64_t> absorbed(n), some(n);
  mollis::workspace workspace;
  counted engine;
  mollis_pks_report report{};
  mollis::pks_options options;
  options.chi = 3;
  options.noise = 0.125;
  options.generator = engine;
  options.report = &report;
  crowd<T> whole;
  mollis::pks_events events(log, absorbed);
  EXPECT(mollis::pks_step<T>(whole.all(), whole.progress, attraction, 1e-3, 20, events, workspace, options));
  EXPECT(whole.progress.step == 20 && whole.progress.count + events.labels_written == n && events.written > 0);
  EXPECT(report.merges == events.written && engine.drawn > 0);
  for (std::size_t i = 0; i < whole.progress.count; ++i) EXPECT(whole.species[i] == whole.labels[i]);

  /* Sensitivities of 1 change nothing; the weights are added as the masses are. */
  {
    crowd<T> weighted;
    std::vector<T> weights = weighted.mass;
    counted again;
    mollis::pks_options as = options;
    as.generator = again;
    as.report = nullptr;
    mollis::pks_events more(log, absorbed);
    mollis::pks_particles<T> all = weighted.all();
    all.weights = weights;
    EXPECT(mollis::pks_step<T>(all, weighted.progress, attraction, 1e-3, 20, more, workspace, as));
    EXPECT(weighted == whole && weights == weighted.mass);
  }

  /* With room for one event the same comes out, in pieces; so it does from pieces of words. */
  piecewise<32> halves;
  piecewise<16> quarters;
  for (const mollis::generator &generator : {mollis::generator(halves), mollis::generator(quarters)}) {
    crowd<T> pieces;
    mollis::pks_events small(one, some);
    options.generator = generator;
    std::size_t times = 0, merges = 0;
    while (!mollis::pks_step<T>(pieces.all(), pieces.progress, attraction, 1e-3, 20 - pieces.progress.step, small, workspace,
                                options)) {
      merges += small.written;
      small.clear();
      ++times;
    }
    EXPECT(pieces == whole && times > 0 && merges + small.written == events.written);
  }
  crowd<T> again;
  mollis::pks_events full;
  mollis::result result;
  counted fresh;
  options.generator = fresh;
  EXPECT(!mollis::pks_step<T>(again.all(), again.progress, attraction, 1e-3, 20, full, workspace, options, result));
  EXPECT(result.status == MOLLIS_ERR_EVENTS_FULL && again.progress.pending > 0);

  /* The built-in generator, meshes, heavy particles, no attraction. */
  options.generator = {};
  options.seed = 3;
  const mollis::mesh mesh = {{-2, -2}, {2, 2}, {16, 16}};
  const mollis::grid_options grid;
  const mollis::pks_attraction<T> attractions[] = {mollis::pks_attraction<T>(),
                                                   mollis::pks_attraction<T>(kernel, 1e-4),
                                                   mollis::pks_attraction<T>(mesh),
                                                   mollis::pks_attraction<T>(mesh, &grid),
                                                   {mesh, &grid, kernel, 0.2}};
  EXPECT(attractions[1].tolerance == 1e-4 && attractions[3].grid == &grid && attractions[4].heavy == 0.2);
  for (const auto &by : attractions) {
    crowd<T> others;
    events.clear();
    EXPECT(mollis::pks_step<T>(others.all(), others.progress, by, 1e-3, 3, events, workspace, options));
    EXPECT(others.progress.step == 3 && others.x[0] != crowd<T>().x[0]);
  }

  /* Refusals. */
  crowd<T> bad;
  bad.x[11][1] = std::numeric_limits<T>::infinity();
  auto step = [&](crowd<T> &of, double dt = 1e-3) {
    return [&of, &attraction, &events, &workspace, &options, dt](mollis::errors e) {
      mollis::pks_step<T>(of.all(), of.progress, attraction, dt, 20, events, workspace, options, e);
    };
  };
  events.clear();
  EXPECT(refused(MOLLIS_ERR_NOT_FINITE, step(bad)).first_bad == 11);
  crowd<T> good;
  refused(MOLLIS_ERR_TIME_STEP, step(good, -1.0));
  good.labels.pop_back();
  refused(MOLLIS_ERR_LENGTH_MISMATCH, step(good));
  crowd<T> gaps;
  refused(MOLLIS_ERR_UNSUPPORTED, [&](mollis::errors e) {
    mollis::pks_step<T>({{gaps.x[0].data(), n / 2, 4 * sizeof(T)}, {gaps.mass.data(), n / 2}, {gaps.labels.data(), n / 2}},
                        gaps.progress, attraction, 1e-3, 20, events, workspace, options, e);
  });
  mollis::workspace none(nullptr, 0);
  EXPECT(refused(MOLLIS_ERR_WORKSPACE_TOO_SMALL, [&](mollis::errors e) {
           mollis::pks_step<T>(gaps.all(), gaps.progress, attraction, 1e-3, 20, events, none, options, e);
         }).bytes_needed > 0);
#ifdef __cpp_exceptions
  counted limited;
  limited.limit = 3000;
  options.generator = limited;
  crowd<T> thrown;
  events.clear();
  throws(5, step(thrown));
  EXPECT(thrown.progress.step < 20);
#endif
}

/* In second.cpp: the header in two units of one program. */
int second(mollis::result &result);

int main() {
  mollis::result result;
  EXPECT(second(result) == MOLLIS_ERR_MASS && result.status == MOLLIS_ERR_MASS);
  layouts();
  sums<double, 1>();
  sums<double, 2>();
  sums<double, 3>();
  essentials<double, 1>();
  essentials<double, 2>();
  essentials<double, 3>();
  sums<float, 1>();
  sums<float, 2>();
  sums<float, 3>();
  essentials<float, 1>();
  essentials<float, 2>();
  essentials<float, 3>();
  own_kernels();
  kernels();
  workspaces();
  vortices();
  diffusing();
  meshes<double>();
  meshes<float>();
  callables();
  coalescence<double>();
  coalescence<float>();
  std::printf("%d checks of mollis.hpp passed, %d failed\n", passed, failed);
  return failed == 0 && passed > 0 ? 0 : 1;
}
