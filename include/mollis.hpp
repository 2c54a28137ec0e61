/*
 * mollis for C++17: templates over the scalar (float, double) and the dimension (1, 2, 3) above the functions of mollis.h.
 *
 *     std::vector<std::array<double, 2>> x(n), gradient(n);
 *     std::vector<double> mass(n);
 *     mollis::kernel<double, 2> kernel(mollis::newtonian(1.0), mollis::compact(2, 4), 0.05);
 *     mollis::workspace workspace;
 *     mollis::outputs<double, 2> out;
 *     out.gradient = gradient;
 *     mollis::field(kernel, {x, mass}, out, workspace);
 *
 * Particles stay where they are: `points` and `column` are views of the program's arrays, of any layout. Memory is held by `kernel` (prepared
 * bytes) and `workspace` alone. What is computed, and to which error, is said in mollis.h at the function of the same name.
 *
 * Errors: a function throws `mollis::error`. If its last argument is a `mollis::result`, it writes the status there and throws nothing. Compiled
 * without exceptions, an error without a `result` calls std::terminate. A call that is refused leaves every output as it was.
 *
 * Functions of the program (a generator, `stop`, ...) are kept by reference and have to live until the call returns. Their exceptions do not
 * cross the library: they are caught, end the call, and are thrown again after it (or kept in `result::exception`).
 *
 * The pool of threads needs libmollis_mt in place of libmollis; everything else is in both.
 */
#ifndef MOLLIS_HPP
#define MOLLIS_HPP

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include "mollis.h"
#include "mollis_mt.h"

namespace mollis {

/* ---------------------------------------------------------------- errors ---------------------------------------------------------------- */

/** A function of the program threw. Beyond the library's own statuses, as the next. */
inline constexpr mollis_status status_thrown = 1000;
/** Memory for a kernel or a workspace could not be had. */
inline constexpr mollis_status status_no_memory = 1001;

/**
 * How a call ended.
 *
 *     mollis::result result;
 *     mollis::field(kernel, {x, mass}, out, workspace, {}, result);
 *     if (!result) std::fprintf(stderr, "%s\n", result.text());
 */
struct result {
  /** MOLLIS_OK, MOLLIS_ERR_*, status_thrown or status_no_memory. */
  mollis_status status = MOLLIS_OK;
  /** MOLLIS_ERR_NOT_FINITE: the first bad source or particle (targets, tracers count after them), or MOLLIS_NONE_BAD. */
  std::uint64_t first_bad = MOLLIS_NONE_BAD;
  /** MOLLIS_ERR_WORKSPACE_TOO_SMALL, status_no_memory: the bytes that are needed. */
  std::size_t bytes_needed = 0;
  /** status_thrown: what was thrown. Null without exceptions. */
  std::exception_ptr exception{};

  explicit operator bool() const noexcept { return status == MOLLIS_OK; }

  /** A sentence that explains the status. */
  const char *text() const noexcept {
    if (status == status_thrown) return "a function of the program threw an exception";
    if (status == status_no_memory) return "out of memory";
    return mollis_status_text(status);
  }
};

/** What functions throw when the library refuses or stops. Where memory is missing they throw std::bad_alloc. */
class error : public std::runtime_error {
public:
  explicit error(const result &from) : std::runtime_error(sentence(from)), result_(from) {}
  mollis_status status() const noexcept { return result_.status; }
  std::uint64_t first_bad() const noexcept { return result_.first_bad; }
  std::size_t bytes_needed() const noexcept { return result_.bytes_needed; }

private:
  static std::string sentence(const result &from) {
    std::string text = from.text();
    if (from.status == MOLLIS_ERR_NOT_FINITE && from.first_bad != MOLLIS_NONE_BAD)
      text += " (element " + std::to_string(from.first_bad) + ")";
    if (from.status == MOLLIS_ERR_WORKSPACE_TOO_SMALL) text += " (" + std::to_string(from.bytes_needed) + " bytes)";
    return text;
  }
  result result_;
};

/** Where errors go, the last argument of every function: thrown if left out, or written to a `result`, which is overwritten. */
class errors {
public:
  errors() noexcept = default;
  errors(result &to) noexcept : to_(&to) {}

  /** Whether they are written to a result. */
  bool kept() const noexcept { return to_ != nullptr; }
  /** Ends a call. */
  void tell(const result &how) const {
    if (to_ != nullptr) {
      *to_ = how;
      return;
    }
#ifdef __cpp_exceptions
    if (how.exception) std::rethrow_exception(how.exception);
    if (how.status == status_no_memory) throw std::bad_alloc();
    if (!how) throw error(how);
#else
    if (!how) std::terminate();
#endif
  }

private:
  result *to_ = nullptr;
};

/** Throws if a function of mollis.h returned an error: `mollis::check(mollis_pks_predict(...))`. */
inline void check(mollis_status status, errors to = {}) {
  result how;
  how.status = status;
  to.tell(how);
}

/* ---------------------------------------------------------------- views ----------------------------------------------------------------- */

namespace detail {

/* The coordinates that a type holds: a number is one, arrays are several. */
template <class E> struct coordinates {
  using type = E;
  static constexpr std::size_t each = 1;
};
template <class E, std::size_t N> struct coordinates<E[N]> {
  using type = E;
  static constexpr std::size_t each = N;
};
template <class E, std::size_t N> struct coordinates<std::array<E, N>> {
  using type = E;
  static constexpr std::size_t each = N;
};
template <class E, std::size_t N> struct coordinates<const std::array<E, N>> {
  using type = const E;
  static constexpr std::size_t each = N;
};

/* What the data() of a container or an array points to. */
template <class C> using element = std::remove_pointer_t<decltype(std::data(std::declval<C &>()))>;

/* Whether elements E are numbers T, and can be written if T is not const. */
template <class E, class T>
inline constexpr bool numbers = std::is_same_v<std::add_const_t<typename coordinates<E>::type>, std::add_const_t<T>> &&
                                (std::is_const_v<T> || !std::is_const_v<typename coordinates<E>::type>);

template <class E> constexpr E *begin(E &number) noexcept { return std::addressof(number); }
template <class E, std::size_t N> constexpr E *begin(E (&several)[N]) noexcept { return several; }
template <class E, std::size_t N> constexpr E *begin(std::array<E, N> &several) noexcept { return several.data(); }
template <class E, std::size_t N> constexpr const E *begin(const std::array<E, N> &several) noexcept { return several.data(); }

/* A type as it is given: arguments of it are converted, and templates are not deduced from them. */
template <class X> struct as_given { using type = X; };
template <class X> using given = typename as_given<X>::type;

} // namespace detail

/**
 * A view of n numbers of the program, such as masses; `column<const double>` is read only.
 *
 *     std::vector<double> mass;               mollis::column<const double> all(mass);
 *     std::vector<vortex> v;                  mollis::column<const double> circulations(v, &vortex::circulation);
 *     double *p;                              mollis::column<double> one_in_three(p, n, 3 * sizeof *p);   // a stride in bytes
 *
 * A column that is not given, `{}`, is not there: an input that is not needed, an output that is not wanted. Strides are multiples of sizeof(T),
 * else calls end in MOLLIS_ERR_MISALIGNED.
 */
template <class T> class column {
public:
  constexpr column() noexcept = default;
  constexpr column(T *first, std::size_t n, std::size_t stride_bytes = sizeof(T)) noexcept
      : first_(first), size_(n), stride_(stride_bytes), given_(true) {}

  /** A container or an array: anything with std::data and std::size. */
  template <class C, class E = detail::element<C>,
            std::enable_if_t<detail::numbers<E, T> && detail::coordinates<E>::each == 1, int> = 0>
  constexpr column(C &&numbers) noexcept : column(std::data(numbers), std::size(numbers)) {}

  /** A member of structures. */
  template <class S, class B, class M, std::enable_if_t<detail::numbers<M, T>, int> = 0>
  constexpr column(S *first, std::size_t n, M B::*member) noexcept
      : column(n == 0 ? nullptr : detail::begin(first->*member), n, sizeof(S)) {}
  template <class C, class B, class M, class = detail::element<C>>
  constexpr column(C &&structures, M B::*member) noexcept : column(std::data(structures), std::size(structures), member) {}

  /** Writable numbers may be read. */
  template <class U, std::enable_if_t<std::is_same_v<const U, T>, int> = 0>
  constexpr column(const column<U> &other) noexcept
      : first_(other.first()), size_(other.size()), stride_(other.stride()), given_(other.given()) {}

  constexpr T *first() const noexcept { return first_; }
  constexpr std::size_t size() const noexcept { return size_; }
  /** Bytes from one to the next. */
  constexpr std::size_t stride() const noexcept { return stride_; }
  constexpr bool given() const noexcept { return given_; }

private:
  T *first_ = nullptr;
  std::size_t size_ = 0, stride_ = sizeof(T);
  bool given_ = false;
};

/**
 * A view of n points in D dimensions; `points<const double, 2>` is read only.
 *
 *     std::vector<std::array<double, 2>> x;   mollis::points<double, 2> a(x);           // also std::span, std::array, double x[100][2]
 *     std::vector<double> flat(2 * n);        mollis::points<double, 2> b(flat);        // x0 y0 x1 y1 ...
 *     std::vector<vortex> v;                  mollis::points<double, 2> c(v, &vortex::x);            // double x[2] or std::array
 *                                             mollis::points<double, 2> d(v, &vortex::px, &vortex::py);
 *     double *px, *py;                        mollis::points<double, 2> e({px, py}, n);
 *     other::vector2 *w;                      mollis::points<double, 2> f(&w[0].x, n, sizeof *w);    // a stride in bytes
 *
 * Points that are not given, `{}`, are not there. Strides as those of `column`; a flat array that does not hold whole points ends a call in
 * MOLLIS_ERR_LENGTH_MISMATCH.
 */
template <class T, std::size_t D> class points {
public:
  static_assert(std::is_same_v<std::remove_const_t<T>, float> || std::is_same_v<std::remove_const_t<T>, double>);
  static_assert(D >= 1 && D <= 3);

  constexpr points() noexcept = default;
  /** Coordinates beside one another: of an array [n][D], or with a stride of structures. */
  constexpr points(T *first, std::size_t n, std::size_t stride_bytes = D * sizeof(T)) noexcept
      : size_(n), stride_(stride_bytes), given_(true) {
    axes_[0] = first;
  }
  template <class E,
            std::enable_if_t<detail::numbers<E, T> && detail::coordinates<E>::each == D && std::is_compound_v<E>, int> = 0>
  constexpr points(E *first, std::size_t n) noexcept : points(n == 0 ? nullptr : detail::begin(*first), n) {}
  /** An array for each coordinate, all with this stride. */
  constexpr points(const std::array<T *, D> &axes, std::size_t n, std::size_t stride_bytes = sizeof(T)) noexcept
      : axes_(axes), size_(n), stride_(stride_bytes), given_(true) {}

  /** A container or an array, of points or of n D numbers. */
  template <class C, class E = detail::element<C>,
            std::enable_if_t<detail::numbers<E, T> && (detail::coordinates<E>::each == D || detail::coordinates<E>::each == 1),
                             int> = 0>
  constexpr points(C &&all) noexcept : given_(true) {
    constexpr std::size_t numbers = D / detail::coordinates<E>::each;
    size_ = std::size(all) / numbers;
    whole_ = std::size(all) % numbers == 0;
    axes_[0] = std::size(all) == 0 ? nullptr : detail::begin(*std::data(all));
  }

  /** Members of structures: one array, or D numbers. */
  template <class S, class... M, class... B, std::enable_if_t<(sizeof...(M) > 0), int> = 0>
  constexpr points(S *first, std::size_t n, M B::*...members) noexcept : size_(n), stride_(sizeof(S)), given_(true) {
    static_assert(sizeof...(M) == D || (sizeof...(M) == 1 && ((detail::coordinates<M>::each == D) && ...)),
                  "one member with D coordinates, or D members");
    static_assert((detail::numbers<M, std::add_const_t<T>> && ...), "members of the view's scalar");
    if (n > 0) {
      std::size_t axis = 0;
      ((axes_[axis++] = detail::begin(first->*members)), ...);
    }
  }
  template <class C, class... M, class... B, class = detail::element<C>, std::enable_if_t<(sizeof...(M) > 0), int> = 0>
  constexpr points(C &&structures, M B::*...members) noexcept
      : points(std::data(structures), std::size(structures), members...) {}

  /** Writable points may be read. */
  template <class U, std::enable_if_t<std::is_same_v<const U, T>, int> = 0>
  constexpr points(const points<U, D> &other) noexcept
      : size_(other.size()), stride_(other.stride()), given_(other.given()), whole_(other.whole()) {
    for (std::size_t k = 0; k < D; ++k) axes_[k] = other.axis(k);
  }

  /** Coordinate k of the first point; null for k > 0 if coordinates are beside one another. */
  constexpr T *axis(std::size_t k) const noexcept { return axes_[k]; }
  constexpr std::size_t size() const noexcept { return size_; }
  constexpr std::size_t stride() const noexcept { return stride_; }
  constexpr bool given() const noexcept { return given_; }
  constexpr bool whole() const noexcept { return whole_; }

private:
  std::array<T *, D> axes_{};
  std::size_t size_ = 0, stride_ = D * sizeof(T);
  bool given_ = false, whole_ = true;
};

/**
 * A view of n matrices of D rows, which are beside one another: a column of their first numbers.
 *
 *     std::vector<std::array<std::array<double, 2>, 2>> h;   mollis::matrices<double, 2> a(h);
 *     std::vector<double> flat(4 * n);                       mollis::matrices<double, 2> b(flat.data(), n);
 *     std::vector<body> v;                                   mollis::matrices<double, 2> c(v, &body::tide);   // double tide[2][2] or std::array
 */
template <class T, std::size_t D> class matrices : public column<T> {
public:
  constexpr matrices() noexcept = default;
  constexpr matrices(T *first, std::size_t n, std::size_t stride_bytes = D * D * sizeof(T)) noexcept
      : column<T>(first, n, stride_bytes) {}
  template <class C, class E = detail::element<C>, std::enable_if_t<sizeof(E) == D * D * sizeof(T) && std::is_compound_v<E>, int> = 0>
  constexpr matrices(C &&all) noexcept
      : matrices(std::size(all) == 0 ? nullptr : detail::begin(*detail::begin(*std::data(all))), std::size(all)) {}
  template <class C, class M, class S>
  constexpr matrices(C &&structures, M S::*member) noexcept
      : matrices(std::size(structures) == 0 ? nullptr : detail::begin(*detail::begin(std::data(structures)->*member)),
                 std::size(structures), sizeof(detail::element<C>)) {
    static_assert(sizeof(M) == D * D * sizeof(T));
  }
};

/** A reference to something that can be called, which has to live as long. Temporaries are refused by the compiler. */
template <class Signature> class function_ref;
template <class R, class... A> class function_ref<R(A...)> {
public:
  constexpr function_ref() noexcept = default;
  template <class F, std::enable_if_t<std::is_object_v<F> && std::is_invocable_r_v<R, F &, A...> &&
                                          !std::is_same_v<std::remove_const_t<F>, function_ref>,
                                      int> = 0>
  function_ref(F &function) noexcept
      : object_(const_cast<void *>(static_cast<const void *>(std::addressof(function)))),
        call_([](void *object, A... arguments) -> R { return (*static_cast<F *>(object))(arguments...); }) {}
  explicit operator bool() const noexcept { return call_ != nullptr; }
  R operator()(A... arguments) const { return call_(object_, arguments...); }

private:
  void *object_ = nullptr;
  R (*call_)(void *, A...) = nullptr;
};

/* ------------------------------------------------------------- how calls run ------------------------------------------------------------- */

/** One call's tasks, as an executor of the program gets them: `task(index, worker)` runs one. */
class task {
public:
  task(mollis_task run, void *data) noexcept : run_(run), data_(data) {}
  void operator()(std::size_t index, std::size_t worker) const noexcept {
    const mollis_status status = run_(data_, index, worker);
    if (status != MOLLIS_OK) status_.store(status, std::memory_order_relaxed);
  }
  mollis_status status() const noexcept { return status_.load(std::memory_order_relaxed); }

private:
  mollis_task run_;
  void *data_;
  mutable std::atomic<mollis_status> status_{MOLLIS_OK};
};

/**
 * Who runs the tasks of a call. By default the calling thread.
 *
 *     auto loop = [](std::size_t tasks, const mollis::task &task) {
 *       #pragma omp parallel for schedule(dynamic) num_threads(4)
 *       for (std::size_t i = 0; i < tasks; ++i) task(i, std::size_t(omp_get_thread_num()));
 *     };
 *     options.run.executor = {4, loop};
 *
 * Each index once, each worker below `workers` for one task at a time; results do not depend on the number of threads.
 */
class executor {
public:
  executor() noexcept = default;
  executor(std::size_t workers, function_ref<void(std::size_t, const task &)> loop) noexcept : loop_(loop) {
    ready_.workers = workers;
  }
  executor(const mollis_executor &ready) noexcept : ready_(ready) {}

  const mollis_executor &ready() const noexcept { return ready_; }
  const function_ref<void(std::size_t, const task &)> &loop() const noexcept { return loop_; }

private:
  mollis_executor ready_{};
  function_ref<void(std::size_t, const task &)> loop_{};
};

/** How a call runs: a member of all options. */
struct run {
  /** MOLLIS_LEVEL_*: the instruction set. */
  std::int32_t level = MOLLIS_LEVEL_BEST;
  mollis::executor executor{};
  /** Asked between tasks, perhaps from several threads: true ends the call with MOLLIS_ERR_STOPPED. */
  function_ref<bool()> stop{};
};

/**
 * Threads that run a call's tasks (needs libmollis_mt).
 *
 *     mollis::pool pool(4);                  // 0: as many as the machine has
 *     options.run.executor = pool;           // the pool has to live until the call returns
 */
class pool {
public:
  explicit pool(std::size_t threads = 0, errors to = {}) {
    mollis_pool *made = nullptr;
    const mollis_status status = mollis_pool_init(threads, &made);
    pool_.reset(made);
    check(status, to);
  }
  /** Runs tasks on the calling thread where the threads could not be started. */
  operator executor() const noexcept {
    mollis_executor ready{};
    if (pool_) mollis_pool_executor(pool_.get(), &ready);
    return ready;
  }

private:
  struct stopper {
    void operator()(mollis_pool *running) const noexcept { mollis_pool_free(running); }
  };
  std::unique_ptr<mollis_pool, stopper> pool_;
};

namespace detail {

/* Bytes at a multiple of MOLLIS_ALIGN. */
class memory {
public:
  memory() noexcept = default;
  memory(memory &&other) noexcept : bytes_(std::move(other.bytes_)), size_(std::exchange(other.size_, 0)) {}
  memory(const memory &other) {
    if (other.size_ == 0) return;
    check(make(other.size_));
    if (size_ > 0) std::memcpy(data(), other.data(), size_);
  }
  memory &operator=(memory other) noexcept {
    std::swap(bytes_, other.bytes_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~memory() = default;

  void *data() const noexcept { return bytes_.get(); }
  std::size_t size() const noexcept { return size_; }
  /* Replaces the bytes. If there is no memory none are left. */
  mollis_status make(std::size_t bytes) noexcept {
    bytes_.reset();
    bytes_.reset(static_cast<unsigned char *>(::operator new (bytes, std::align_val_t{MOLLIS_ALIGN}, std::nothrow)));
    size_ = bytes_ ? bytes : 0;
    return bytes_ ? MOLLIS_OK : status_no_memory;
  }

private:
  struct free {
    void operator()(unsigned char *bytes) const noexcept { ::operator delete (bytes, std::align_val_t{MOLLIS_ALIGN}); }
  };
  std::unique_ptr<unsigned char, free> bytes_;
  std::size_t size_ = 0;
};

} // namespace detail

/**
 * Scratch memory for calls, one at a time.
 *
 *     mollis::workspace grows;                                 // asks for memory when a call needs more
 *     mollis::workspace fixed(buffer, sizeof buffer);          // never does: MOLLIS_ERR_WORKSPACE_TOO_SMALL and the bytes needed
 */
class workspace {
public:
  workspace() noexcept = default;
  workspace(void *buffer, std::size_t bytes) noexcept : buffer_(buffer), bytes_(bytes), fixed_(true) {}

  void *data() const noexcept { return fixed_ ? buffer_ : own_.data(); }
  std::size_t size() const noexcept { return fixed_ ? bytes_ : own_.size(); }
  /** Makes room. Contents are kept if there is enough. */
  mollis_status reserve(std::size_t bytes) noexcept {
    if (bytes <= size()) return MOLLIS_OK;
    if (fixed_) return MOLLIS_ERR_WORKSPACE_TOO_SMALL;
    return own_.make(bytes);
  }

private:
  void *buffer_ = nullptr;
  std::size_t bytes_ = 0;
  bool fixed_ = false;
  detail::memory own_;
};

namespace detail {

/* One call: its first error, and what functions of the program threw. */
class call {
public:
  explicit call(errors to, const mollis::run *how = nullptr) noexcept : to_(to) {
    if (how == nullptr) return;
    mollis_run_init(&run_, sizeof run_);
    run_.level = how->level;
    run_.first_bad = &result_.first_bad;
    run_.bytes_needed = &result_.bytes_needed;
    if (how->stop) {
      stop_ = how->stop;
      run_.stop_context = this;
      run_.should_stop = [](void *context) -> std::int32_t {
        auto &self = *static_cast<call *>(context);
        bool stop = false;
        return self.guard([&] { stop = self.stop_(); }) != MOLLIS_OK || stop;
      };
    }
    executor_ = how->executor.ready();
    if (how->executor.loop()) {
      loop_ = how->executor.loop();
      executor_.context = this;
      executor_.parallel_for = [](void *context, std::size_t tasks, mollis_task one, void *data) -> std::int32_t {
        auto &self = *static_cast<call *>(context);
        const task each(one, data);
        const mollis_status status = self.guard([&] { self.loop_(tasks, each); });
        return status != MOLLIS_OK ? status : each.status();
      };
    }
    if (executor_.parallel_for != nullptr || executor_.workers > 0) run_.executor = &executor_;
  }
  call(const call &) = delete;
  call &operator=(const call &) = delete;
  ~call() = default;

  const mollis_run *run() const noexcept { return &run_; }

  /* Runs a function of the program. An exception is kept and becomes a status. */
  template <class Body> mollis_status guard(Body body) noexcept {
#ifdef __cpp_exceptions
    try {
      body();
    } catch (...) {
      if (!threw_.exchange(true)) result_.exception = std::current_exception();
      return status_thrown;
    }
#else
    body();
#endif
    return MOLLIS_OK;
  }

  /* Notes a status. Whether the call goes on. */
  bool good(mollis_status status) noexcept {
    if (result_.status == MOLLIS_OK) result_.status = threw_ ? status_thrown : status;
    return result_.status == MOLLIS_OK;
  }

  /* The same of a request for memory. */
  bool room(mollis_status status, std::size_t bytes) noexcept {
    if (!good(status)) result_.bytes_needed = bytes;
    return result_.status == MOLLIS_OK;
  }

  /* For functions that take no run: finds the first of n elements that is not finite. */
  template <class Find, class T> void find_bad(Find *find, std::size_t n, std::size_t each, const T *values) noexcept {
    if (result_.status == MOLLIS_ERR_NOT_FINITE && result_.first_bad == MOLLIS_NONE_BAD)
      find(n, each, values, &result_.first_bad);
  }

  /* Tells how the call ended, of which every part was good or not. */
  void end(bool all_good) const {
    if (!all_good || to_.kept()) to_.tell(result_);
  }
  /* The same; EVENTS_FULL is not thrown. */
  bool end_of_step(bool all_good) const {
    if (result_.status != MOLLIS_ERR_EVENTS_FULL || to_.kept()) end(all_good);
    return all_good;
  }

private:
  errors to_;
  result result_{};
  std::atomic<bool> threw_{false};
  mollis_run run_{};
  mollis_executor executor_{};
  function_ref<bool()> stop_{};
  function_ref<void(std::size_t, const task &)> loop_{};
};

/* Puts views into the structures of the library, and remembers the first that does not fit. */
class fitting {
public:
  explicit fitting(std::size_t n) noexcept : n_(n) {}

  template <class T, std::size_t D, class S> void put(const points<T, D> &from, T *(&axes)[D], S &stride) noexcept {
    if (!from.given()) return;
    for (std::size_t k = 0; k < D; ++k) axes[k] = from.axis(k);
    stride = look(from.size(), from.stride(), sizeof(T));
    if (!from.whole()) fail(MOLLIS_ERR_LENGTH_MISMATCH);
  }
  template <class T, class S> void put(const column<T> &from, T *&first, S &stride) noexcept {
    if (!from.given()) return;
    first = from.first();
    stride = look(from.size(), from.stride(), sizeof(T));
  }
  /* For functions that take arrays without gaps. */
  template <class T> T *packed(const column<T> &from) noexcept {
    T *first = nullptr;
    std::size_t stride = 1;
    put(from, first, stride);
    if (from.given() && n_ > 1 && stride != 1) fail(MOLLIS_ERR_UNSUPPORTED);
    return first;
  }
  template <class T, std::size_t D> auto packed(const points<T, D> &from) noexcept -> T (*)[D] {
    T *axes[D] = {};
    std::size_t stride = D;
    put(from, axes, stride);
    if (from.given() && n_ > 0 && ((n_ > 1 && stride != D) || (D > 1 && axes[D - 1] != nullptr))) fail(MOLLIS_ERR_UNSUPPORTED);
    return reinterpret_cast<T(*)[D]>(axes[0]);
  }
  mollis_status status() const noexcept { return status_; }

private:
  std::size_t look(std::size_t n, std::size_t stride, std::size_t each) noexcept {
    if (n != n_) fail(MOLLIS_ERR_LENGTH_MISMATCH);
    if (stride % each != 0) fail(MOLLIS_ERR_MISALIGNED);
    return stride / each;
  }
  void fail(mollis_status status) noexcept {
    if (status_ == MOLLIS_OK) status_ = status;
  }
  std::size_t n_;
  mollis_status status_ = MOLLIS_OK;
};

/* The functions of mollis.h for a scalar and a dimension, and for a scalar. */
template <class T, std::size_t D> struct abi;
template <class T> struct scalar_abi;

#define MOLLIS_HPP_ABI(T, D, F)                                                        \
  template <> struct abi<T, D> {                                                       \
    using sources = mollis_sources##D##F;                                              \
    using targets = mollis_targets##D##F;                                              \
    using outputs = mollis_outputs##D##F;                                              \
    using particles = mollis_particles##D##F;                                          \
    static constexpr auto kernel_bytes = &mollis_kernel##D##_bytes##F;                 \
    static constexpr auto kernel_prepare = &mollis_kernel##D##_prepare##F;             \
    static constexpr auto kernel_eval = &mollis_kernel##D##_eval##F;                   \
    static constexpr auto field_bytes = &mollis_field##D##_workspace_bytes##F;         \
    static constexpr auto field_eval = &mollis_field##D##_eval##F;                     \
    static constexpr auto field_text = &mollis_field##D##_text##F;                     \
    static constexpr auto essential_bytes = &mollis_field##D##_essential_bytes##F;     \
    static constexpr auto essential = &mollis_field##D##_essential##F;                 \
    static constexpr auto blob_bytes = &mollis_blob##D##_workspace_bytes##F;           \
    static constexpr auto blob_step = &mollis_blob##D##_step##F;                       \
    static constexpr auto moments = &mollis_moments##D##F;                             \
    static constexpr auto stable_step = &mollis_stable_step##D##F;                     \
    static constexpr auto stable_step_anywhere = &mollis_stable_step##D##_anywhere##F; \
    static constexpr auto overlap = &mollis_overlap##D##F;                             \
    static constexpr auto distance_norm = &mollis_distance_norm##D##F;                 \
    static constexpr auto mollifier_eval = &mollis_mollifier##D##_eval##F;             \
  }
#define MOLLIS_HPP_SCALAR(T, F)                                          \
  MOLLIS_HPP_ABI(T, 1, F);                                               \
  MOLLIS_HPP_ABI(T, 2, F);                                               \
  MOLLIS_HPP_ABI(T, 3, F);                                               \
  template <> struct scalar_abi<T> {                                     \
    using particles = mollis_pks_particles##F;                           \
    using grid_outputs = mollis_grid2_outputs##F;                        \
    static constexpr auto pks_bytes = &mollis_pks_workspace_bytes##F;    \
    static constexpr auto pks_step = &mollis_pks_step##F;                \
    static constexpr auto grid_bytes = &mollis_grid2_workspace_bytes##F; \
    static constexpr auto grid_eval = &mollis_grid2_eval##F;             \
    static constexpr auto norm = &mollis_norm##F;                        \
    static constexpr auto first_bad = &mollis_first_bad##F;              \
  }
MOLLIS_HPP_SCALAR(double, );
MOLLIS_HPP_SCALAR(float, _f32);
#undef MOLLIS_HPP_SCALAR
#undef MOLLIS_HPP_ABI

/* At most N values, held by value. One more than the library takes is held, so that it refuses. */
template <class T, std::size_t N> class few {
public:
  few() noexcept = default;
  few(const T &one) noexcept : size_(1) { values_[0] = one; }
  few(std::initializer_list<T> all) noexcept : few(all.begin(), all.end()) {}
  template <class C, class = std::enable_if_t<std::is_same_v<const T, std::add_const_t<element<const C>>>>>
  few(const C &all) noexcept : few(std::data(all), std::data(all) + std::size(all)) {}
  const T *data() const noexcept { return values_.data(); }
  std::size_t size() const noexcept { return size_; }

private:
  few(const T *from, const T *to) noexcept {
    for (; from != to && size_ < values_.size(); ++from) values_[size_++] = *from;
  }
  std::array<T, N + 1> values_{};
  std::size_t size_ = 0;
};

} // namespace detail

/* ---------------------------------------------------------------- kernels ---------------------------------------------------------------- */

/** A mollifier without its length delta. */
using mollifier = mollis_mollifier;
/** No mollifier: the singular kernel. */
constexpr mollifier none() noexcept { return {MOLLIS_MOLLIFIER_NONE, 0, 0}; }
/** Compact polynomial of order 2, 4, 6 or 8 and exponent 1 to 9; delta is the radius of the support. */
constexpr mollifier compact(std::int32_t order, std::int32_t exponent) noexcept {
  return {MOLLIS_MOLLIFIER_COMPACT, order, exponent};
}
/** Sum of Gaussians of order 2 (Lamb and Oseen's vortex), 4 or 6. */
constexpr mollifier gaussian(std::int32_t order = 2) noexcept { return {MOLLIS_MOLLIFIER_GAUSSIAN, order, 0}; }
/** Plummer's softening; Rosenhead and Moore's kernel. Newtonian kernels only, as the next two. */
constexpr mollifier plummer() noexcept { return {MOLLIS_MOLLIFIER_PLUMMER, 0, 0}; }
/** The high-order algebraic kernel of vortex methods (Winckelmans and Leonard). */
constexpr mollifier algebraic() noexcept { return {MOLLIS_MOLLIFIER_ALGEBRAIC, 0, 0}; }
/** Vatistas' vortex with n = 2, in the plane. */
constexpr mollifier vatistas() noexcept { return {MOLLIS_MOLLIFIER_VATISTAS, 0, 0}; }
/** Richardson combination of order 4, 6 or 8 of compact polynomials of order 2 and exponent 1 to 9; delta is the radius of the support. */
constexpr mollifier richardson(std::int32_t order, std::int32_t exponent) noexcept {
  return {MOLLIS_MOLLIFIER_RICHARDSON, order, exponent};
}

/** One term of a kernel sum: a coefficient (+1 attracts where K grows, -1 repels) times K. */
using term = mollis_kernel_term;
/** |x|/2, log|x|/(2 pi), -1/(4 pi |x|) in 1, 2, 3 dimensions. */
constexpr term newtonian(double coefficient = 1.0) noexcept { return {MOLLIS_KERNEL_NEWTONIAN, 0, coefficient, {0.0, 0.0}}; }
/** |x|^p/p, log|x| for p = 0. */
constexpr term power(double coefficient, double p) noexcept { return {MOLLIS_KERNEL_POWER, 0, coefficient, {p, 0.0}}; }
/** e^{-|x|/length}, a Morse term. */
constexpr term exponential(double coefficient, double length) noexcept {
  return {MOLLIS_KERNEL_EXPONENTIAL, 0, coefficient, {length, 0.0}};
}
/** (Laplacian - k^2) K = Dirac. */
constexpr term screened(double coefficient, double k) noexcept { return {MOLLIS_KERNEL_SCREENED, 0, coefficient, {k, 0.0}}; }

/** The terms of a sum: one, a list `{power(1, 2), newtonian(-1)}`, or a container. */
using terms = detail::few<term, MOLLIS_KERNEL_MAX_TERMS>;

/**
 * A radial kernel of the program (mollis_radial_kernel). It is called while a kernel is prepared, and never again.
 *
 *     auto well = [](double r) { return std::array<double, 3>{K(r), slope(r) / r, laplacian(r)}; };
 *     mollis::radial own(well, 2.0);         // the largest distance that matters
 *     own.knots = {0.5 * h, h};              // where it is not smooth
 *     mollis::kernel<double, 3> kernel(own);
 */
struct radial {
  radial(function_ref<std::array<double, 3>(double)> function, double largest) noexcept : evaluate(function), reach(largest) {}

  function_ref<std::array<double, 3>(double)> evaluate;
  double coefficient = 1.0;
  double reach;
  /** The largest error with which it is accepted, else MOLLIS_ERR_KERNEL_FIT. 0: 1e-10, in single precision 1e-5. */
  double tolerance = 0.0;
  double least = 0.0;
  detail::few<double, MOLLIS_KERNEL_MAX_KNOTS> knots{};
  /** If not null, the errors of K, K'/r and the Laplacian that were reached are written here. */
  std::array<double, 3> *reached = nullptr;
};

/**
 * A kernel, prepared for sums: terms and perhaps one of the program's own, mollified over delta.
 *
 *     mollis::kernel<double, 2> vortex(mollis::newtonian(1.0), mollis::gaussian(), 0.05);
 *     mollis::kernel<float, 3> sum({mollis::power(1.0, 2.0), mollis::newtonian(-1.0)}, mollis::none());
 *
 * It holds its bytes; copies are independent. A kernel that was not made, or whose making failed, is refused by every function. Several threads
 * may use one at a time.
 *
 * Errors: those of mollis_kernel2_prepare, and what the own kernel throws.
 */
template <class T, std::size_t D> class kernel {
public:
  kernel() noexcept = default;
  kernel(const mollis::terms &sum, mollifier over, T delta = 0, errors to = {}) { prepare(sum, nullptr, over, delta, to); }
  kernel(const radial &own, mollifier over = none(), T delta = 0, errors to = {}) { prepare({}, &own, over, delta, to); }
  kernel(const mollis::terms &sum, const radial &own, mollifier over = none(), T delta = 0, errors to = {}) {
    prepare(sum, &own, over, delta, to);
  }

  /** The prepared bytes, for functions of mollis.h and to be saved. */
  const void *data() const noexcept { return bytes_.data(); }
  std::size_t size() const noexcept { return bytes_.size(); }

private:
  struct called {
    detail::call *call;
    const radial *own;
  };

  void prepare(const mollis::terms &sum, const radial *own, mollifier over, T delta, errors to) {
    using abi = detail::abi<T, D>;
    detail::call call(to);
    mollis_radial_kernel radial{};
    called pair{&call, own};
    if (own != nullptr) {
      radial.context = &pair;
      radial.evaluate = [](void *context, double r, double *out) -> mollis_status {
        auto &self = *static_cast<called *>(context);
        return self.call->guard([&] {
          const std::array<double, 3> values = self.own->evaluate(r);
          std::copy(values.begin(), values.end(), out);
        });
      };
      radial.coefficient = own->coefficient;
      radial.reach = own->reach;
      radial.tolerance = own->tolerance;
      radial.least = own->least;
      radial.n_knots = own->knots.size();
      radial.knots = own->knots.data();
      radial.errors = own->reached != nullptr ? own->reached->data() : nullptr;
    }
    const mollis_radial_kernel *given = own != nullptr ? &radial : nullptr;
    std::size_t bytes = 0;
    const bool good = call.good(abi::kernel_bytes(sum.data(), sum.size(), given, over, &bytes)) &&
                      call.room(bytes_.make(bytes), bytes) &&
                      call.good(abi::kernel_prepare(bytes_.data(), bytes, sum.data(), sum.size(), given, over, delta));
    if (!good) bytes_ = {};
    call.end(good);
  }

  detail::memory bytes_;
};

/* ----------------------------------------------------------------- sums ------------------------------------------------------------------ */

/**
 * The sources of a sum.
 *
 *     mollis::sources<double, 2> from{x, mass};              // the kernel's delta for all
 *     mollis::sources<double, 2> vortices{{v, &vortex::x}, {v, &vortex::circulation}, {v, &vortex::core}};   // a radius for each
 */
template <class T, std::size_t D> struct sources {
  points<const T, D> positions{};
  /** Of any sign. */
  column<const T> masses{};
  /** Core radii, one for each source, in place of the kernel's delta: of Newtonian kernels with a mollifier. */
  column<const T> radii{};
  /** In space: vector strengths in place of masses; the gradient is then the velocity of vortex elements. */
  points<const T, D> strengths{};
  /** Core radii of targets that are not the sources, where the option `pair_radius` makes a pair's of both. */
  column<const T> target_radii{};
};

/** Where results go, of as many elements as there are targets. What is not given is not computed. */
template <class T, std::size_t D> struct outputs {
  column<T> potential{};
  points<T, D> gradient{};
  column<T> laplacian{};
  /** Second derivatives, symmetric. */
  matrices<T, D> hessian{};
  /** What all results are multiplied by; not 0. */
  double factor = 1.0;
  /** true: results are added to what is there; false: overwritten. */
  bool add = false;
};

/** How a sum is computed: the members of mollis_field_options, and these. */
struct field_options : mollis_field_options {
  field_options() noexcept : mollis_field_options() { mollis_field_options_init(this, sizeof(mollis_field_options)); }
  mollis::run run{};
  /** What a sum did is added here if not null. */
  mollis_field_counts *counts = nullptr;
};

namespace detail {

template <class T, std::size_t D> mollis_status fit(const sources<T, D> &from, typename abi<T, D>::sources &to) noexcept {
  fitting all(to.n = from.positions.size());
  all.put(from.positions, to.positions, to.stride);
  all.put(from.masses, to.masses, to.mass_stride);
  all.put(from.radii, to.radii, to.radius_stride);
  all.put(from.strengths, to.strengths, to.strength_stride);
  return all.status();
}

template <class T, std::size_t D>
mollis_status fit(const points<const T, D> &from, const column<const T> &radii, typename abi<T, D>::targets &to) noexcept {
  fitting all(to.n = from.size());
  all.put(from, to.positions, to.stride);
  all.put(radii, to.radii, to.radius_stride);
  return all.status();
}

template <class T, std::size_t D>
mollis_status fit(const outputs<T, D> &from, std::size_t n, typename abi<T, D>::outputs &to) noexcept {
  fitting all(n);
  all.put(from.potential, to.potential, to.potential_stride);
  all.put(from.gradient, to.gradient, to.gradient_stride);
  all.put(from.laplacian, to.laplacian, to.laplacian_stride);
  all.put(from.hessian, to.hessian, to.hessian_stride);
  to.factor = from.factor;
  to.add = from.add ? 1 : 0;
  return all.status();
}

/* The arguments of a sum in the structures of the library. */
template <class T, std::size_t D> struct sum {
  typename abi<T, D>::sources from{};
  typename abi<T, D>::targets at{};
  typename abi<T, D>::outputs to{};
  bool at_sources, fits;

  sum(call &call, const sources<T, D> &f, const points<const T, D> &a, const outputs<T, D> &t) noexcept
      : at_sources(!a.given()), fits(call.good(fit<T, D>(f, from)) && call.good(at_sources ? MOLLIS_OK : fit<T, D>(a, f.target_radii, at)) &&
                                     call.good(fit<T, D>(t, at_sources ? from.n : at.n, to))) {}
  const typename abi<T, D>::targets *targets() const noexcept { return at_sources ? nullptr : &at; }
};

} // namespace detail

/**
 * Sums over sources: u(x_i) = sum_j m_j K_delta(x_i - x_j), its gradient, Laplacian and second derivatives, at every target
 * (mollis_field2_eval).
 *
 *     mollis::field(kernel, {x, mass}, {{}, gradient}, workspace);                 // at the sources
 *     mollis::field(kernel, {x, mass}, places, {potential}, workspace);            // at targets
 *     mollis::field_options options;
 *     options.combination[0] = 0, options.combination[1] = 1;                      // vortices: the gradient output is the velocity
 *     options.tolerance = 1e-6;                                                    // allows the fast multipole method
 *
 * n sources, as many masses and radii; outputs as long as the targets; all overwritten, or multiplied and added to (`outputs`).
 * Errors: those of mollis_field2_eval, with the first bad source or target; MOLLIS_ERR_LENGTH_MISMATCH.
 */
template <class T, std::size_t D>
void field(const kernel<T, D> &by, const detail::given<sources<T, D>> &from, const detail::given<points<const T, D>> &at,
           const detail::given<outputs<T, D>> &out, workspace &in, const field_options &options = {}, errors to = {}) {
  using abi = detail::abi<T, D>;
  detail::call call(to, &options.run);
  const detail::sum<T, D> sum(call, from, at, out);
  std::size_t bytes = 0;
  call.end(sum.fits &&
           call.good(abi::field_bytes(by.data(), by.size(), &sum.from, sum.targets(), &sum.to, &options, call.run(), &bytes)) &&
           call.room(in.reserve(bytes), bytes) &&
           call.good(abi::field_eval(by.data(), by.size(), &sum.from, sum.targets(), &sum.to, &options, call.run(), in.data(),
                                     in.size(), options.counts)));
}

template <class T, std::size_t D>
void field(const kernel<T, D> &by, const detail::given<sources<T, D>> &from, const detail::given<outputs<T, D>> &out,
           workspace &in, const field_options &options = {}, errors to = {}) {
  field<T, D>(by, from, {}, out, in, options, to);
}

/** A sentence that says which method a sum will use, and why; empty after an error. */
template <class T, std::size_t D>
std::string field_text(const kernel<T, D> &by, const detail::given<sources<T, D>> &from,
                       const detail::given<points<const T, D>> &at, const detail::given<outputs<T, D>> &out,
                       const field_options &options = {}, errors to = {}) {
  using abi = detail::abi<T, D>;
  detail::call call(to);
  const detail::sum<T, D> sum(call, from, at, out);
  std::size_t length = 0;
  char none = 0;
  std::string text;
  bool good = sum.fits &&
              call.good(abi::field_text(by.data(), by.size(), &sum.from, sum.targets(), &sum.to, &options, &none, 1, &length));
  if (good) {
    text.resize(length + 1);
    good = call.good(
        abi::field_text(by.data(), by.size(), &sum.from, sum.targets(), &sum.to, &options, &text[0], length + 1, nullptr));
    text.resize(good ? length : 0);
  }
  call.end(good);
  return text;
}

/** Where what is essential goes, without gaps, each with room for as much. */
template <class T, std::size_t D> struct essential_outputs {
  points<T, D> positions{};
  column<T> masses{};
  /** Which of the sources each is, 2^64 - 1 for one that stands for several; may be left out. */
  column<std::uint64_t> origins{};
};

/**
 * Fewer sources that act as these do on all targets in a box (mollis_field2_essential): what a process sends to those that own the targets.
 *
 *     std::vector<std::array<double, 2>> corners{{1, 0}, {2, 1}};                  // the lower and the upper corner of each box
 *     std::vector<std::uint64_t> starts(corners.size() / 2 + 1);
 *     mollis::essential(kernel, {x, mass}, corners, 1e-6, starts, {}, workspace);                     // how many there are
 *     std::vector<std::array<double, 2>> y(starts.back());
 *     std::vector<double> m(starts.back());
 *     mollis::essential(kernel, {x, mass}, corners, 1e-6, starts, {y, m}, workspace);
 *
 * Corners and starts have no gaps. Those for box b are overwritten at starts[b] up to starts[b + 1]; without outputs only `starts` is written.
 * Errors: those of mollis_field2_essential, with the first bad source; MOLLIS_ERR_NO_ROOM if there are more, with `starts` complete;
 * MOLLIS_ERR_LENGTH_MISMATCH, MOLLIS_ERR_UNSUPPORTED (gaps).
 */
template <class T, std::size_t D>
void essential(const kernel<T, D> &by, const detail::given<sources<T, D>> &from,
               const detail::given<points<const T, D>> &corners, double tolerance,
               const detail::given<column<std::uint64_t>> &starts, const detail::given<essential_outputs<T, D>> &out,
               workspace &in, const mollis::run &how = {}, errors to = {}) {
  using abi = detail::abi<T, D>;
  detail::call call(to, &how);
  typename abi::sources sources{};
  detail::fitting of_corners(corners.size()), of_starts(starts.size()), room(out.positions.size());
  const std::size_t boxes = corners.size() / 2;
  const auto *box = reinterpret_cast<const T(*)[2][D]>(of_corners.packed(corners));
  std::uint64_t *begin = of_starts.packed(starts);
  T(*positions)[D] = room.packed(out.positions);
  T *masses = room.packed(out.masses);
  std::uint64_t *origins = room.packed(out.origins);
  const bool lengths = corners.size() == 2 * boxes && starts.size() == boxes + 1;
  std::size_t bytes = 0;
  call.end(call.good(detail::fit<T, D>(from, sources)) && call.good(lengths ? MOLLIS_OK : MOLLIS_ERR_LENGTH_MISMATCH) &&
           call.good(of_corners.status()) && call.good(of_starts.status()) && call.good(room.status()) &&
           call.good(abi::essential_bytes(by.data(), by.size(), &sources, tolerance, &bytes)) &&
           call.room(in.reserve(bytes), bytes) &&
           call.good(abi::essential(by.data(), by.size(), &sources, tolerance, boxes, box, begin, out.positions.size(),
                                    positions, masses, origins, call.run(), in.data(), in.size())));
}

/** A rectangle cut into cells: `{{-1, -1}, {1, 1}, {64, 64}}` are its corners and the cells along x and y. */
using mesh = mollis_mesh2;

/** Which field a mesh is solved for: the members of mollis_grid2_options, and how the call runs. */
struct grid_options : mollis_grid2_options {
  grid_options() noexcept : mollis_grid2_options() { mollis_grid2_options_init(this, sizeof(mollis_grid2_options)); }
  mollis::run run{};
};

/** Where the results of a field on a mesh go; over the nodes without gaps, along x first. */
template <class T> struct grid_outputs {
  /** At the targets. */
  points<T, 2> gradient{};
  column<T> node_mass{}, node_potential{};
  points<T, 2> node_gradient{};
  /** Total mass and its centre. */
  std::array<T, 3> *total = nullptr;
  /** The number of sources outside the mesh. */
  std::uint64_t *outside = nullptr;
};

/**
 * The Newtonian field of masses in the plane by a mesh (mollis_grid2_eval): about n operations.
 *
 *     mollis::grid<double>({{-1, -1}, {1, 1}, {64, 64}}, {x, mass}, {}, {gradient}, workspace);
 *
 * Targets `{}`: the sources. Every output is overwritten. Errors: those of mollis_grid2_eval; MOLLIS_ERR_LENGTH_MISMATCH.
 */
template <class T>
void grid(const mesh &on, const detail::given<sources<T, 2>> &from, const detail::given<points<const T, 2>> &at,
          const grid_outputs<T> &out, workspace &in, const grid_options &options = {}, errors to = {}) {
  using abi = detail::scalar_abi<T>;
  detail::call call(to, &options.run);
  const detail::sum<T, 2> sum(call, from, at, {{}, out.gradient});
  detail::fitting nodes((on.cells[0] + 1) * (on.cells[1] + 1));
  typename abi::grid_outputs grid{};
  std::copy(std::begin(sum.to.gradient), std::end(sum.to.gradient), std::begin(grid.gradient));
  grid.gradient_stride = sum.to.gradient_stride;
  grid.node_mass = nodes.packed(out.node_mass);
  grid.node_potential = nodes.packed(out.node_potential);
  grid.node_gradient = nodes.packed(out.node_gradient);
  grid.total = reinterpret_cast<T(*)[3]>(out.total);
  grid.outside = out.outside;
  std::size_t bytes = 0;
  call.end(sum.fits && call.good(nodes.status()) &&
           call.good(abi::grid_bytes(&on, &sum.from, sum.targets(), &grid, &options, call.run(), &bytes)) &&
           call.room(in.reserve(bytes), bytes) &&
           call.good(abi::grid_eval(&on, &sum.from, sum.targets(), &grid, &options, call.run(), in.data(), in.size())));
}

/* ------------------------------------------------------------- the blob method ----------------------------------------------------------- */

/** The particles of the blob method, or points that follow their flow (tracers). */
template <class T, std::size_t D> struct particles {
  /** Advanced in place. */
  points<T, D> positions{};
  /** Density times h^D, only read; of tracers left out. */
  column<const T> masses{};
  /** Advanced in place. */
  column<T> density{};
  /** At the end; overwritten. */
  points<T, D> velocity{};
  column<T> divergence{};
};

/** How a run of the blob method is done, as in mollis_blob_options. */
template <class T, std::size_t D> struct blob_options {
  /** Stops with MOLLIS_ERR_ENERGY_ROSE when the energy rises beyond rounding; only reports it for combination[0] <= 0. */
  bool watch_energy = false;
  double tolerance = 0.0;
  /** Called after each step with the steps completed, positions and densities; true ends the run with MOLLIS_ERR_STOPPED. */
  function_ref<bool(std::size_t, points<const T, D>, column<const T>)> after_step{};
  mollis::run run{};
  /** (a, b), in 2D: the velocity is -(a grad u + b (grad u rotated by +90 degrees)). (0, -1) with circulations as masses: vortices. */
  double combination[2] = {1.0, 0.0};
  /** nu of rho_t = nu Laplacian(rho^m) by blobs, added to the velocity; 0 is none. Masses must not be negative then, and densities and divergences are not wanted. */
  double diffusion = 0.0;
  /** m >= 1. */
  double diffusion_exponent = 1.0;
  /** The blobs' function and its length, some distances of neighbours. */
  mollifier diffusion_mollifier = gaussian(2);
  double diffusion_length = 0.0;
};

/**
 * Advances the aggregation equation by `steps` steps of length dt (mollis_blob2_step).
 *
 *     mollis::blob_step(kernel, {x, mass, density}, {}, 0.01, 20, workspace);      // no tracers
 *
 * Positions and densities are advanced in place, velocity and divergence overwritten. Returns the report. Errors: those of mollis_blob2_step,
 * with the first bad particle; the state is then that of the last completed step. MOLLIS_ERR_LENGTH_MISMATCH.
 */
template <class T, std::size_t D>
mollis_blob_report blob_step(const kernel<T, D> &by, const detail::given<particles<T, D>> &of,
                             const detail::given<particles<T, D>> &tracers, double dt, std::size_t steps, workspace &in,
                             const detail::given<blob_options<T, D>> &options = {}, errors to = {}) {
  using abi = detail::abi<T, D>;
  detail::call call(to, &options.run);
  typename abi::particles all[2] = {};
  const particles<T, D> *const views[2] = {&of, &tracers};
  bool fits = true;
  for (std::size_t k = 0; k < 2; ++k) {
    detail::fitting fit(all[k].n = views[k]->positions.size());
    fit.put(views[k]->positions, all[k].positions, all[k].stride);
    fit.put(views[k]->masses, all[k].masses, all[k].mass_stride);
    fit.put(views[k]->density, all[k].density, all[k].density_stride);
    fit.put(views[k]->velocity, all[k].velocity, all[k].velocity_stride);
    fit.put(views[k]->divergence, all[k].divergence, all[k].divergence_stride);
    fits = fits && call.good(fit.status());
  }
  struct after {
    detail::call *call;
    const blob_options<T, D> *options;
    std::size_t n;
  } context{&call, &options, all[0].n};
  mollis_blob_options blob{};
  mollis_blob_options_init(&blob, sizeof blob);
  blob.watch_energy = options.watch_energy ? 1 : 0;
  blob.tolerance = options.tolerance;
  blob.combination[0] = options.combination[0];
  blob.combination[1] = options.combination[1];
  blob.diffusion = options.diffusion;
  blob.diffusion_exponent = options.diffusion_exponent;
  blob.diffusion_mollifier = options.diffusion_mollifier;
  blob.diffusion_length = options.diffusion_length;
  if (options.after_step) {
    blob.context = &context;
    blob.after_step = [](void *pointer, std::size_t done, const void *positions, const void *density) -> std::int32_t {
      auto &self = *static_cast<after *>(pointer);
      bool stop = false;
      const points<const T, D> x(static_cast<const T *>(positions), self.n);
      const column<const T> rho = density ? column<const T>(static_cast<const T *>(density), self.n) : column<const T>();
      return self.call->guard([&] { stop = self.options->after_step(done, x, rho); }) != MOLLIS_OK || stop;
    };
  }
  const auto *other = tracers.positions.given() ? &all[1] : nullptr;
  mollis_blob_report report{};
  std::size_t bytes = 0;
  call.end(fits && call.good(abi::blob_bytes(by.data(), by.size(), &all[0], other, &blob, call.run(), &bytes)) &&
           call.room(in.reserve(bytes), bytes) &&
           call.good(abi::blob_step(by.data(), by.size(), &all[0], other, dt, steps, &blob, call.run(), in.data(), in.size(),
                                    &report)));
  return report;
}

/* --------------------------------------------------------- coalescing particles --------------------------------------------------------- */

/** The arrays of coalescing particles, without gaps, each with room for as many; the first progress.count are alive. */
template <class T> struct pks_particles {
  points<T, 2> positions{};
  /** Positive. */
  column<T> masses{};
  /** All different. */
  column<std::uint64_t> labels{};
  column<std::uint32_t> species{};
  /** Positive: masses over sensitivities. */
  column<T> weights{};
};

/** Time, and what a run counts: `progress.count = n` at the beginning. It belongs to the state. */
struct pks_progress : mollis_pks_progress {
  pks_progress() noexcept : mollis_pks_progress() {}
  explicit pks_progress(std::uint64_t n) noexcept : mollis_pks_progress() { count = n; }
};

/** Where merges are written, one after the other; `labels` gets the absorbed labels. */
struct pks_events : mollis_pks_events {
  pks_events() noexcept : mollis_pks_events() {}
  pks_events(const column<mollis_pks_event> &log, const column<std::uint64_t> &absorbed) noexcept : mollis_pks_events() {
    events = log.first();
    room = log.size();
    labels = absorbed.first();
    labels_room = absorbed.size();
  }
  /** Makes room: nothing is written. */
  void clear() noexcept { written = labels_written = 0; }
};

/** Where the attraction comes from. What is passed has to live until the step returns. */
template <class T> struct pks_attraction : mollis_pks_attraction {
  /** None. */
  pks_attraction() noexcept : mollis_pks_attraction() {}
  /** The sum of a kernel over all particles; `error` may be spent for speed. */
  explicit pks_attraction(const mollis::kernel<T, 2> &sum, double error = 0.0) noexcept : mollis_pks_attraction() {
    this->kind = MOLLIS_PKS_ATTRACTION_SUM;
    this->kernel = sum.data();
    this->kernel_bytes = sum.size();
    this->tolerance = error;
  }
  /** A mesh, in free space. */
  explicit pks_attraction(const mollis::mesh &on, const mollis_grid2_options *how = nullptr) noexcept
      : mollis_pks_attraction() {
    this->kind = MOLLIS_PKS_ATTRACTION_MESH;
    this->mesh = &on;
    this->grid = how;
  }
  /** A mesh, and particles of at least this mass act pair by pair by a kernel. */
  pks_attraction(const mollis::mesh &on, const mollis_grid2_options *how, const mollis::kernel<T, 2> &pairs,
                 double least_mass) noexcept
      : pks_attraction(on, how) {
    this->kernel = pairs.data();
    this->kernel_bytes = pairs.size();
    this->heavy = least_mass;
  }
};

/**
 * A reference to a random generator of the program: any UniformRandomBitGenerator whose range is all numbers of some bits, such as
 * std::mt19937_64. Words of 64 bits are joined from draws of fewer, the first one lowest. By default the built-in Philox generator with
 * the options' seed.
 */
class generator {
public:
  generator() noexcept = default;
  template <class G, class = typename G::result_type>
  generator(G &engine) noexcept
      : state_(std::addressof(engine)), fill_([](void *state, std::uint64_t *out, std::size_t n) {
          constexpr std::uint64_t range = G::max();
          static_assert(G::min() == 0 && range > 0 && (range & (range + 1)) == 0,
                        "the generator's range is not that of some bits");
          constexpr unsigned bits = width(range);
          for (std::size_t i = 0; i < n; ++i) {
            std::uint64_t word = 0;
            for (unsigned low = 0; low < 64; low += bits)
              word |= static_cast<std::uint64_t>((*static_cast<G *>(state))()) << low;
            out[i] = word;
          }
        }) {}

  explicit operator bool() const noexcept { return fill_ != nullptr; }
  void fill(std::uint64_t *out, std::size_t n) const { fill_(state_, out, n); }

private:
  static constexpr unsigned width(std::uint64_t range) { return range > 1 ? 1 + width(range / 2) : 1; }
  void *state_ = nullptr;
  void (*fill_)(void *, std::uint64_t *, std::size_t) = nullptr;
};

/** What a run is made with: the members of mollis_pks_options (set at least chi and noise), and these. */
struct pks_options : mollis_pks_options {
  pks_options() noexcept : mollis_pks_options() { mollis_pks_options_init(this, sizeof(mollis_pks_options)); }
  mollis::generator generator{};
  mollis::run run{};
  /** What steps did is added here if not null. */
  mollis_pks_report *report = nullptr;
};

/**
 * Advances coalescing particles by `steps` steps of length dt (mollis_pks_step).
 *
 *     std::mt19937_64 engine(1);
 *     mollis::pks_options options;
 *     options.chi = 1, options.noise = 0.1, options.generator = engine;
 *     mollis::pks_progress progress(n);
 *     mollis::pks_events events(log, absorbed);            // std::vector<mollis_pks_event>, std::vector<std::uint64_t>
 *     while (!mollis::pks_step<double>({x, mass, labels}, progress, mollis::pks_attraction<double>(kernel), dt, last - progress.step,
 *                                      events, workspace, options)) {
 *       ...                                                // read the events
 *       events.clear();
 *     }
 *
 * Particles are advanced and merged in place, `progress` is updated, events are appended to. Returns whether all steps were made: false if the
 * event buffer is full (which is not thrown; a `result` holds MOLLIS_ERR_EVENTS_FULL). The same workspace, not used in between, goes on then.
 * Errors: those of mollis_pks_step, with the first bad particle, and what the generator throws; the state is then that of the last completed step.
 */
template <class T>
bool pks_step(const detail::given<pks_particles<T>> &of, mollis_pks_progress &progress, const pks_attraction<T> &attraction,
              double dt, std::size_t steps, mollis_pks_events &events, workspace &in, const pks_options &options,
              errors to = {}) {
  using abi = detail::scalar_abi<T>;
  detail::call call(to, &options.run);
  typename abi::particles all{};
  detail::fitting fit(all.room = of.positions.size());
  all.positions = fit.packed(of.positions);
  all.masses = fit.packed(of.masses);
  all.labels = fit.packed(of.labels);
  all.species = fit.packed(of.species);
  all.weights = fit.packed(of.weights);
  struct drawing {
    detail::call *call;
    const generator *from;
  } context{&call, &options.generator};
  const mollis_generator stream{&context, [](void *pointer, std::uint64_t *out, std::size_t n) -> std::int32_t {
                                  auto &self = *static_cast<drawing *>(pointer);
                                  return self.call->guard([&] { self.from->fill(out, n); });
                                }};
  std::size_t bytes = 0;
  return call.end_of_step(call.good(fit.status()) &&
                          call.good(abi::pks_bytes(all.room, &attraction, &options, call.run(), &bytes)) &&
                          call.room(in.reserve(bytes), bytes) &&
                          call.good(abi::pks_step(&all, &progress, &attraction, options.generator ? &stream : nullptr, dt,
                                                  steps, &events, &options, call.run(), in.data(), in.size(), options.report)));
}

/* -------------------------------------------------------------- diagnostics -------------------------------------------------------------- */
/* These take arrays without gaps (MOLLIS_ERR_UNSUPPORTED), and return 0 or zeros after an error that is written to a `result`. */

namespace detail {

/* Calls a function with the addresses of n elements each. It takes no run: the first bad element of an input is looked for here. */
template <class T, class F, class... Views> void diagnose(errors to, std::size_t n, F function, const Views &...views) {
  call call(to);
  fitting fit(n);
  const auto addresses = std::make_tuple(fit.packed(views)...);
  const bool good = call.good(fit.status()) && call.good(std::apply(function, addresses));
  const auto look = [&call, n](auto *first) {
    using element = std::remove_pointer_t<decltype(first)>;
    if constexpr (std::is_const_v<std::remove_all_extents_t<element>>)
      call.find_bad(scalar_abi<T>::first_bad, n, sizeof(element) / sizeof(T), reinterpret_cast<const T *>(first));
  };
  if (!good) std::apply([&look](auto *...first) { (look(first), ...); }, addresses);
  call.end(good);
}

} // namespace detail

/** Total mass, sum of |m|, centre of mass and second moment about it. */
template <class T, std::size_t D> struct moments_of {
  T mass{}, absolute_mass{};
  std::array<T, D> centre{};
  T second{};
};

/** The moments of particles (mollis_moments2): `mollis::moments<double, 2>(x, mass).second`. */
template <class T, std::size_t D>
moments_of<T, D> moments(const detail::given<points<const T, D>> &x, const detail::given<column<const T>> &masses,
                         errors to = {}) {
  moments_of<T, D> out;
  const auto function = [&](auto *at, auto *m) {
    auto *centre = reinterpret_cast<T(*)[D]>(&out.centre);
    return detail::abi<T, D>::moments(x.size(), at, m, &out.mass, &out.absolute_mass, centre, &out.second);
  };
  detail::diagnose<T>(to, x.size(), function, x, masses);
  return out;
}

/** A time step with which RK4 is stable at this state (mollis_stable_step2); with blob_options::combination divide it by 1.07 sqrt(a^2 + b^2). */
template <class T, std::size_t D>
T stable_step(const kernel<T, D> &by, const detail::given<points<const T, D>> &x, const detail::given<column<const T>> &masses,
              errors to = {}) {
  T step = 0;
  const auto function = [&](auto *at, auto *m) {
    return detail::abi<T, D>::stable_step(by.data(), by.size(), x.size(), at, m, &step);
  };
  detail::diagnose<T>(to, x.size(), function, x, masses);
  return step;
}

/** One that is stable at every state of this total |mass| and diameter (mollis_stable_step2_anywhere). */
template <class T, std::size_t D>
T stable_step_anywhere(const kernel<T, D> &by, detail::given<T> absolute_mass, detail::given<T> diameter, errors to = {}) {
  T step = 0;
  check(detail::abi<T, D>::stable_step_anywhere(by.data(), by.size(), absolute_mass, diameter, &step), to);
  return step;
}

/** The smallest overlap of blobs, delta over their spacing (mollis_overlap2): `mollis::overlap<double, 2>(delta, mass, density)`. */
template <class T, std::size_t D>
T overlap(T delta, const detail::given<column<const T>> &masses, const detail::given<column<const T>> &densities,
          errors to = {}) {
  T smallest = 0;
  const auto function = [&](auto *m, auto *rho) { return detail::abi<T, D>::overlap(masses.size(), delta, m, rho, &smallest); };
  detail::diagnose<T>(to, masses.size(), function, masses, densities);
  return smallest;
}

/** The norm (sum |v_i|^p cell)^(1/p), or the largest |v_i| for infinite p (mollis_norm). */
template <class T> T norm(const detail::given<column<const T>> &values, T cell, detail::given<T> p, errors to = {}) {
  T out = 0;
  const auto function = [&](auto *v) { return detail::scalar_abi<T>::norm(values.size(), v, cell, p, &out); };
  detail::diagnose<T>(to, values.size(), function, values);
  return out;
}

/** The norm of the distances |a_i - b_i| (mollis_distance_norm2). */
template <class T, std::size_t D>
T distance_norm(const detail::given<points<const T, D>> &a, const detail::given<points<const T, D>> &b, T cell,
                detail::given<T> p, errors to = {}) {
  T out = 0;
  const auto function = [&](auto *x, auto *y) { return detail::abi<T, D>::distance_norm(a.size(), x, y, cell, p, &out); };
  detail::diagnose<T>(to, a.size(), function, a, b);
  return out;
}

/** K_delta(r), K_delta'(r)/r and the Laplacian (mollis_kernel2_eval) as columns; those not given are not computed. */
template <class T> struct kernel_values { column<T> value{}, gradient_factor{}, laplacian{}; };

/** A kernel's values at distances r: `mollis::evaluate(kernel, r, {value})`. */
template <class T, std::size_t D>
void evaluate(const kernel<T, D> &of, const detail::given<column<const T>> &r, const detail::given<kernel_values<T>> &out,
              errors to = {}) {
  const auto function = [&](auto *...all) { return detail::abi<T, D>::kernel_eval(of.data(), of.size(), r.size(), all...); };
  detail::diagnose<T>(to, r.size(), function, r, out.value, out.gradient_factor, out.laplacian);
}

/** The functions of r of a mollifier (mollis_mollifier2_eval) as columns; those not given are not computed. */
template <class T> struct mollifier_values {
  column<T> density{}, density_slope{}, potential{}, gradient_factor{}, hessian_factor{}, enclosed_mass{};
};

/** A mollifier's values at distances r: `mollis::evaluate<double, 2>(mollis::compact(4, 9), 0.1, r, {density})`. */
template <class T, std::size_t D>
void evaluate(const mollifier &of, T delta, const detail::given<column<const T>> &r,
              const detail::given<mollifier_values<T>> &out, errors to = {}) {
  const auto function = [&](auto *...all) { return detail::abi<T, D>::mollifier_eval(of, delta, r.size(), all...); };
  detail::diagnose<T>(to, r.size(), function, r, out.density, out.density_slope, out.potential, out.gradient_factor,
                      out.hessian_factor, out.enclosed_mass);
}

} // namespace mollis

#endif // MOLLIS_HPP
