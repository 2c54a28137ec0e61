"""The C library: its functions and numbers, errors, buffers, threads and interruption."""

from __future__ import annotations

import contextlib
import enum
import os
import signal
import sys
import threading
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, Callable, Iterator

import numpy as np

from ._declarations import ffi

_NAMES = {"win32": "mollis_mt.dll", "darwin": "libmollis_mt.dylib"}
lib = ffi.dlopen(str(Path(__file__).with_name(_NAMES.get(sys.platform, "libmollis_mt.so"))))
if lib.mollis_abi_version() != lib.MOLLIS_ABI_VERSION:
    raise ImportError("the shared library of mollis is of another version than its declarations")

# Numbers of the header, such as MOLLIS_METHOD_FMM.
_NUMBERS = {name: getattr(lib, name) for name in dir(lib) if name.startswith("MOLLIS_")}

Status = enum.IntEnum(  # type: ignore[misc]
    "Status", {"OK": 0} | {k.removeprefix("MOLLIS_ERR_"): v for k, v in _NUMBERS.items() if k.startswith("MOLLIS_ERR_")}
)
Status.__doc__ = "The statuses of the C library, without their prefix MOLLIS_ERR_."

# What a function of the host returns after an exception; statuses of the library are below 256.
HOST_FAILED = 1000


class Error(Exception):
    """A call that the library refused or ended.

    `status` is a `Status` (an int if it is none of the library's), `first_bad` the index of the first element that is
    not finite (particles or sources, then targets or tracers), where that is known, else None. `report` is the report
    of a run that ended early, else None.
    """

    def __init__(self, status: int, first_bad: int | None = None) -> None:
        self.status = Status(status) if status in Status._value2member_map_ else status
        self.first_bad = first_bad
        self.report: Any = None
        text = ffi.string(lib.mollis_status_text(status)).decode()
        super().__init__(text if first_bad is None else f"{text} (index {first_bad})")

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (int(self.status), self.first_bad)


def number(group: str, name: str) -> int:
    """The number MOLLIS_GROUP_NAME of the header: `number("METHOD", "fmm")`."""
    key = f"MOLLIS_{group}_"
    value = _NUMBERS.get(key + str(name).upper().replace("-", "_"))
    if value is None:
        known = [k.removeprefix(key).lower().replace("_", "-") for k in _NUMBERS if k.startswith(key)]
        raise ValueError(f"{name!r} is none of {', '.join(sorted(known))}")
    return value


class Api(dict):
    """The functions of one dimension and scalar type: `api["field#_eval"]` is mollis_field2_eval, or
    mollis_field3_eval_f32.
    """

    def __init__(self, dimension: int, dtype: np.dtype) -> None:
        super().__init__()
        self.dimension, self.dtype, self.suffix = dimension, dtype, "_f32" if dtype == np.float32 else ""
        self.real = "float" if self.suffix else "double"
        self.array, self.pointer = ffi.typeof(f"{self.real}[]"), ffi.typeof(f"{self.real} *")
        self.item = dtype.itemsize

    def name(self, template: str) -> str:
        return f"mollis_{template.replace('#', str(self.dimension))}{self.suffix}"

    __hash__ = object.__hash__  # type: ignore[assignment]

    def __missing__(self, template: str) -> Any:
        function = self[template] = getattr(lib, self.name(template))
        return function


_APIS = {(d, t): Api(d, t) for d in (1, 2, 3) for t in (np.dtype(np.float32), np.dtype(np.float64))}


def api(dimension: int, dtype: Any) -> Api:
    """The functions for this dimension and type."""
    found = _APIS.get((dimension, np.dtype(dtype)))
    if found is None:
        raise ValueError(
            f"dimension {dimension} and dtype {np.dtype(dtype)}: they are 1, 2 or 3, and float32 or float64"
        )
    return found


# Arrays


def address(array: np.ndarray) -> int:
    """The address of an array's first element."""
    return array.__array_interface__["data"][0]


def pointer(api: Api, array: np.ndarray) -> Any:
    """A C pointer to an array's first element. The caller keeps the array."""
    if array.flags.c_contiguous:
        return ffi.from_buffer(api.array, array)
    return ffi.cast(api.pointer, address(array))


def in_place(array: np.ndarray, item: int) -> bool:
    """Whether the library can read an array where it is: a positive number of items from one element to the next."""
    flags = array.flags
    if not flags.aligned:
        return False
    return flags.c_contiguous or array.shape[0] < 2 or (array.strides[0] > 0 and array.strides[0] % item == 0)


def vector(api: Api, values: Any, n: int, name: str) -> np.ndarray:
    """`n` numbers as an array that the library can read; a single number stands for n equal ones."""
    array = np.asarray(values, api.dtype)
    if array.shape != (n,):
        if array.ndim == 0:
            return np.full(n, array)
        raise ValueError(f"{name} has shape {array.shape}, not ({n},)")
    return array if in_place(array, api.item) else array.copy()


def points(api: Api, values: Any, name: str, n: int | None = None) -> np.ndarray:
    """Points (n, D) as an array that the library can read; in one dimension (n,) too."""
    array = np.asarray(values, api.dtype)
    if array.ndim == 1 and api.dimension == 1:
        array = array[:, np.newaxis]
    shape = array.shape
    if len(shape) != 2 or shape[1] != api.dimension or (n is not None and shape[0] != n):
        raise ValueError(f"{name} has shape {shape}, not ({'n' if n is None else n}, {api.dimension})")
    return array if in_place(array, api.item) else array.copy(order="C")


def contiguous(api: Api, values: Any, name: str, n: int | None = None) -> np.ndarray:
    """Points (n, D) without gaps."""
    return np.ascontiguousarray(points(api, values, name, n))


def writable(api: Api, array: Any, shape: tuple[int, ...], name: str) -> np.ndarray:
    """Checks an array that is written: nothing is converted."""
    if not isinstance(array, np.ndarray) or (array.dtype is not api.dtype and array.dtype != api.dtype):
        kind = array.dtype if isinstance(array, np.ndarray) else type(array).__name__
        raise TypeError(f"{name} is written and has to be an array of {api.dtype}, not {kind}")
    if len(shape) == 2 and shape[1] == 1 and array.ndim == 1:
        array = array[:, np.newaxis]
    if array.shape != shape:
        raise ValueError(f"{name} has shape {array.shape}, not {shape}")
    if not array.flags.writeable:
        raise ValueError(f"{name} is read-only")
    if not in_place(array, api.item):
        raise ValueError(
            f"{name} is written and has to be aligned, with a positive multiple of {api.item} bytes between elements"
        )
    return array


def output(api: Api, asked: Any, shape: tuple[int, ...], name: str) -> np.ndarray | None:
    """An output: None for False, a new array for True, else the array given."""
    if asked is None or asked is False:
        return None
    if asked is True:
        return np.empty(shape, api.dtype)
    return writable(api, asked, shape, name)


def put_vector(api: Api, struct: Any, field: str, array: np.ndarray | None, stride: str) -> None:
    """Writes pointer and stride of n numbers into a structure that is zero."""
    if array is None:
        return
    if array.flags.c_contiguous:
        setattr(struct, field, ffi.from_buffer(api.array, array))
    else:
        setattr(struct, field, pointer(api, array))
        setattr(struct, stride, array.strides[0] // api.item)


def put_points(api: Api, struct: Any, field: str, array: np.ndarray | None, stride: str) -> None:
    """Writes the pointers to the coordinates of n points and the stride into a structure that is zero."""
    if array is None:
        return
    pointers = getattr(struct, field)
    if array.flags.c_contiguous:
        pointers[0] = ffi.from_buffer(api.array, array)
        return
    start, (step, width) = address(array), array.strides
    for k in range(api.dimension):
        pointers[k] = ffi.cast(api.pointer, start + k * width)
    setattr(struct, stride, step // api.item if array.shape[0] > 1 else api.dimension)


def put_matrices(api: Api, struct: Any, field: str, array: np.ndarray | None, stride: str) -> None:
    """Writes pointer and stride of n matrices, each without gaps, into a structure that is zero."""
    if array is None:
        return
    item, dimension = api.item, api.dimension
    if array.strides[1:] != (dimension * item, item):
        raise ValueError("the matrices of second derivatives must each be without gaps")
    setattr(struct, field, pointer(api, array))
    if array.shape[0] > 1:
        setattr(struct, stride, array.strides[0] // item)


# Threads

_pools: dict[int, Any] = {}
_lock = threading.Lock()
_default = 0


def set_threads(threads: int) -> None:
    """Sets how many threads calls use that do not say so; 0, the default, means as many as the machine has (at most
    256).

    Results do not depend on it, bit for bit.
    """
    global _default
    if threads < 0:
        raise ValueError("threads must not be negative")
    _default = int(threads)


def executor(threads: int | None) -> Any:
    """The executor of a pool of so many threads; NULL for one."""
    threads = _default if threads is None else threads
    if threads == 1:
        return ffi.NULL
    found = _pools.get(threads)
    if found is None:
        if threads < 0:
            raise ValueError("threads must not be negative")
        with _lock:
            pool = ffi.new("mollis_pool **")
            check(lib.mollis_pool_init(threads, pool))
            found = ffi.new("mollis_executor *")
            check(lib.mollis_pool_executor(pool[0], found))
            _pools[threads] = found
    return found


def _forget_pools() -> None:
    """A forked process has none of the threads."""
    global _lock
    _lock = threading.Lock()
    _pools.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forget_pools)

# Calls

# Larger workspaces are given back after a call.
_KEEP = 64 << 20
_ATOI = ffi.cast("int32_t (*)(void *)", ffi.addressof(ffi.dlopen("msvcrt" if os.name == "nt" else None), "atoi"))
_TOO_SMALL = lib.MOLLIS_ERR_WORKSPACE_TOO_SMALL
_NONE_BAD = lib.MOLLIS_NONE_BAD
memmove = ffi.memmove


def aligned(size: int) -> np.ndarray:
    """Bytes that begin at a multiple of MOLLIS_ALIGN."""
    align = lib.MOLLIS_ALIGN
    block = np.empty(size + align - 1, np.uint8)
    start = -address(block) % align
    return block[start : start + size]


class Frame:
    """The structures of one call and its workspace. A thread keeps them for its next call."""

    def __init__(self) -> None:
        self.structs: dict[tuple[str, int], Any] = {}
        self.fields: dict[Api, Any] = {}
        self.run = ffi.new("mollis_run *")
        check(lib.mollis_run_init(self.run, ffi.sizeof("mollis_run")))
        self.first_bad, self.needed = ffi.new("uint64_t[1]", [_NONE_BAD]), ffi.new("size_t[1]")
        self.run.first_bad, self.run.bytes_needed = self.first_bad, self.needed
        self.level_set = False
        # A number as text, read by C's atoi, which is therefore a should_stop that any thread may call without Python.
        self.stop = ffi.new("char[2]", b"0")
        self.run.stop_context = self.stop
        self.resize(0)

    def resize(self, size: int) -> None:
        """Another workspace, of so many bytes."""
        self.block = aligned(size)
        self.workspace, self.size = ffi.from_buffer("char[]", self.block), size

    def new(self, kind: str, which: int = 0) -> Any:
        """A structure of this type, all zero; `which` tells several apart."""
        found = self.structs.get((kind, which))
        if found is None:
            struct = ffi.new(f"{kind} *")
            size = ffi.sizeof(struct[0])
            found = self.structs[kind, which] = struct, bytes(size), size
        struct, zeros, size = found
        memmove(struct, zeros, size)
        return struct

    def sums(self, api: Api) -> tuple[Any, Any, Any]:
        """The structures for sources, targets and outputs, all zero."""
        found = self.fields.get(api)
        if found is None:
            kinds = [api.name(kind) for kind in ("sources#", "targets#", "outputs#")]
            starts = [0]
            for kind in kinds:
                starts.append(starts[-1] + ffi.sizeof(kind))
            block = ffi.new("double[]", starts[-1] // 8 + 1)
            structs = tuple(
                ffi.cast(f"{kind} *", ffi.cast("char *", block) + start) for kind, start in zip(kinds, starts)
            )
            found = self.fields[api] = structs, block, bytes(starts[-1]), starts[-1]
        structs, block, zeros, size = found
        memmove(block, zeros, size)
        return structs

    def options(self, kind: str) -> Any:
        """The structure of this type of options, with the defaults."""
        found = self.new(kind)
        check(getattr(lib, f"{kind}_init")(found, ffi.sizeof(found[0])))
        return found

    def call(self, function: Any, before: tuple[Any, ...], *after: Any) -> int:
        """Calls with workspace enough; returns the status."""
        status = function(*before, self.run, self.workspace, self.size, *after)
        while status == _TOO_SMALL and self.needed[0] > self.size:
            self.resize(self.needed[0])
            status = function(*before, self.run, self.workspace, self.size, *after)
        return status

    def error(self, status: int) -> Error:
        """The exception for a status."""
        bad, self.first_bad[0], self.needed[0] = self.first_bad[0], _NONE_BAD, 0
        return Error(status, None if bad == _NONE_BAD else bad)


class _Frames(threading.local):
    def __init__(self) -> None:
        self.free: list[Frame] = []


_frames = _Frames()


def take(executor: Any, level: str = "best") -> Frame:
    """A frame of this thread that no call is using: a callback that calls again gets another one. `give` it back."""
    free = _frames.free
    frame = free.pop() if free else Frame()
    frame.run.executor = executor
    if level != "best" or frame.level_set:
        frame.run.level = number("LEVEL", level)
        frame.level_set = level != "best"
    return frame


def give(frame: Frame) -> None:
    """Keeps a frame for the thread's next call."""
    if frame.size > _KEEP:
        frame.resize(0)
    _frames.free.append(frame)


@contextlib.contextmanager
def frame(executor: Any, level: str = "best") -> Iterator[Frame]:
    """A frame for the block."""
    one = take(executor, level)
    try:
        yield one
    finally:
        give(one)


def check(status: int, values: np.ndarray | None = None) -> None:
    """Raises if a status is none of success; `values` are searched for what is not finite."""
    if status != 0:
        bad = None
        if status == lib.MOLLIS_ERR_NOT_FINITE and values is not None:
            finite = np.isfinite(values).reshape(len(values), -1).all(axis=1)
            bad = None if finite.all() else int(np.argmin(finite))
        raise Error(status, bad)


def ends(answer: object) -> bool:
    """Whether a function of the host ends a run: it returned True, of Python or NumPy, and not just something."""
    return isinstance(answer, (bool, np.bool_)) and bool(answer)


class Callbacks:
    """Runs a call of the library so that Ctrl-C ends it, and functions of the host in the thread that made it.

    In the main thread the call runs in a second thread, as Python handles signals in the main one alone. Exceptions
    of the host's functions, and of signal handlers, end the call and are raised after it.
    """

    def __init__(self, frame: Frame) -> None:
        self.frame = frame
        self.failure: BaseException | None = None
        self.queue: SimpleQueue[Any] | None = None
        self.serving = False

    def guard(self, function: Callable[..., int]) -> Callable[..., int]:
        """A function that keeps an exception and returns a status instead."""

        def guarded(*arguments: Any) -> int:
            try:
                return function(*arguments)
            except BaseException as failure:
                self.failure = self.failure or failure
                return HOST_FAILED

        return guarded

    def here(self, function: Callable[..., int]) -> Callable[..., int]:
        """A function that runs in the thread that called `run`."""
        guarded = self.guard(function)

        def asked(*arguments: Any) -> int:
            if self.queue is None:
                return guarded(*arguments)
            answer: SimpleQueue[int] = SimpleQueue()
            self.queue.put((lambda: guarded(*arguments), answer))
            return answer.get()

        return asked

    def run(self, call: Callable[[], int], long: bool = True) -> int:
        """Makes the call and returns its status, or raises what a function of the host raised."""
        frame = self.frame
        try:
            if long and threading.current_thread() is threading.main_thread():
                frame.stop[0] = b"0"
                frame.run.should_stop = _ATOI
                status = self._apart(call)
            else:
                status = call()
        finally:
            frame.run.should_stop = ffi.NULL
        if self.failure is not None:
            raise self.failure
        return status

    def _apart(self, call: Callable[[], int]) -> int:
        self.queue = queue = SimpleQueue[Any]()
        result: list[int] = []

        def work() -> None:
            try:
                result.append(call())
            except BaseException as failure:
                self.failure = self.failure or failure
            queue.put(None)

        def asked(handler: Callable[..., Any]) -> Callable[..., Any]:
            return lambda *event: handler(*event) if self.serving else queue.put((lambda: handler(*event), None))

        # The call reads and writes memory that is the host's again once this function ends. An exception of a signal
        # handler must therefore find it waiting, where it is kept until the call has ended, and nowhere else.
        with _handlers(asked):
            thread = threading.Thread(target=work, name="mollis", daemon=True)
            thread.start()
            while True:
                try:
                    item = queue.get(timeout=0.2)  # Windows handles Ctrl-C between waits only.
                except Empty:
                    continue
                if item is None:
                    break
                self._serve(*item)
            thread.join()
        return result[0] if result else HOST_FAILED

    def _serve(self, function: Callable[[], int], answer: Any) -> None:
        """Calls a function of the host, which signals interrupt; an exception ends the run."""
        status = HOST_FAILED
        try:
            self.serving = True
            status = function()
            self.serving = False
        except BaseException as failure:
            self.serving = False
            self.failure = self.failure or failure
            self.frame.stop[0] = b"1"
        if answer is not None:
            answer.put(status)


@contextlib.contextmanager
def _handlers(other: Callable[[Callable[..., Any]], Callable[..., Any]]) -> Iterator[None]:
    """Handles signals by `other(handler)` in place of every handler that is a function of Python."""
    found: dict[int, Any] = {}
    try:
        for number in sorted(signal.valid_signals()):
            handler = signal.getsignal(number)
            if callable(handler) and not isinstance(handler, signal.Handlers):
                found[number] = handler
                signal.signal(number, other(handler))
        yield
    finally:
        # Ctrl-C's comes back last: it may raise at once.
        for number, handler in sorted(found.items(), key=lambda item: item[0] == signal.SIGINT):
            signal.signal(number, handler)
