//! Makes `include/mollis.f90` from the header: constants, types, the C functions as they are, and subroutines without kinds on every literal.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::ops::RangeInclusive;

use anyhow::{Context, Result, bail, ensure};

use crate::text;

/// The longest line that every compiler of Fortran 2018 takes.
const WIDTH: usize = 132;

/// Pointers to structures that may be null, and arrays that are structures one after the other.
const OPTIONAL: [&str; 8] = ["options", "run", "targets", "tracers", "generator", "own", "report", "counters"];
const ARRAYS: [&str; 2] = ["terms", "species"];
/// Pointers to one number.
const SCALARS: [&str; 11] =
    ["bytes", "length", "step", "norm", "smallest", "first", "mass", "absolute_mass", "second", "noise", "rate"];

/// Pointers to one point.
const POINTS: [&str; 2] = ["centre", "points"];

const HEAD: &str = "\
! mollis: particles that interact through softened potentials.
!
! The rules and the documentation of every function are those of mollis.h. Here
! * constants and types have their names in C; members have defaults of 0 and null, which mean \"not there\";
! * mollis_... are the C functions. Pointers that may be null are optional arguments; arrays are what they are in C, so that
!   `double (*x)[2]` is `x(2, n)`;
! * without the prefix the same as subroutines, over both kinds of reals where their arguments tell them apart: sizes are
!   default integers, a prepared kernel or a workspace is an array of bytes, a text is a character variable, padded with blanks,
!   ..._init needs no size, and a status that nobody asks for stops the program where it is not MOLLIS_OK;
! * status_text(status) says what a status means;
! * mollis_at(x) is the address of the first element of a variable with the attribute target, of any type, for members of
!   structures.
!
! Made from include/mollis.h by `cargo xtask header`: do not edit.
module mollis
  use, intrinsic :: iso_c_binding
  implicit none
  public
  private :: tell, fill, address_of

";

/// The ranks that `mollis_at` takes, scalars included. (Compilers lack assumed rank: flang 19 does.)
const RANKS: RangeInclusive<usize> = 0..=7;

/// One argument of a function, or one member of a structure.
#[derive(Clone, Debug)]
struct Declared {
    name: String,
    /// The C type without `const`, `struct` and stars.
    kind: String,
    is_const: bool,
    stars: usize,
    /// Lengths in brackets.
    dimensions: Vec<String>,
    /// `(*name)[..]`: a pointer to arrays.
    to_array: bool,
    /// A pointer to a function.
    to_function: bool,
}

struct Function {
    name: String,
    result: String,
    arguments: Vec<Declared>,
}

/// The module.
pub(super) fn module(header: &str) -> Result<String> {
    let code = text::code_only(header);
    let functions = functions(&code)?;
    let mut out = HEAD.to_owned();
    constants(header, &functions, &mut out)?;
    let structures = structures(&code)?;
    for (name, members) in &structures {
        writeln!(out, "\n  type, bind(c) :: {name}")?;
        for member in members {
            writeln!(out, "    {}", member_of(member)?)?;
        }
        writeln!(out, "  end type")?;
    }
    out.push_str("\n  interface\n");
    for function in &functions {
        c_function(function, &mut out)?;
    }
    out.push_str("  end interface\n");
    let thin: Vec<&Function> = functions.iter().filter(|f| has_thin_layer(f)).collect();
    generics(&thin, &mut out)?;
    address_interface(&mut out)?;
    out.push_str("\ncontains\n");
    for rank in RANKS {
        address_of_rank(rank, &mut out)?;
    }
    out.push_str(HELPERS);
    for function in &thin {
        subroutine(function, &mut out)?;
    }
    out.push_str("end module\n");
    Ok(out)
}

const HELPERS: &str = "
  ! The address of bytes; null if there are none.
  function address_of(bytes) result(address)
    integer(c_int8_t), intent(in), target, contiguous :: bytes(:)
    type(c_ptr) :: address
    address = c_null_ptr
    if (size(bytes) > 0) address = c_loc(bytes)
  end function

  ! A text of C, up to its end or that of its array; blanks follow.
  subroutine fill(text, letters)
    character(*), intent(out) :: text
    character(kind=c_char), intent(in) :: letters(:)
    integer :: k
    text = ' '
    do k = 1, min(len(text), size(letters))
      if (letters(k) == c_null_char) exit
      text(k:k) = letters(k)
    end do
  end subroutine

  ! What a status means.
  function status_text(status) result(text)
    integer(c_int32_t), intent(in) :: status
    character(:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    integer :: n
    call c_f_pointer(mollis_status_text(status), letters, [200])
    n = 1
    do while (letters(n) /= c_null_char)
      n = n + 1
    end do
    allocate(character(n - 1) :: text)
    call fill(text, letters)
  end function

  ! Hands a status to the caller, or stops where it is an error.
  subroutine tell(code, status)
    integer(c_int32_t), intent(in) :: code
    integer(c_int32_t), intent(out), optional :: status
    if (present(status)) then
      status = code
    else if (code /= MOLLIS_OK) then
      print '(2a)', 'mollis: ', status_text(code)
      error stop
    end if
  end subroutine
";

/// What is defined. A name that a function has as well, which is another one in C alone, ends in `_HERE`.
fn constants(header: &str, functions: &[Function], out: &mut String) -> Result<()> {
    for line in header.lines() {
        let Some((name, value)) = line.strip_prefix("#define MOLLIS_").and_then(|rest| rest.split_once(' ')) else {
            continue;
        };
        if name.contains('(') || value.is_empty() {
            continue;
        }
        let taken = functions.iter().any(|f| f.name == format!("mollis_{}", name.to_lowercase()));
        let name = if taken { format!("{name}_HERE") } else { name.to_owned() };
        match value.trim() {
            "UINT64_MAX" => writeln!(out, "  integer(c_int64_t), parameter :: MOLLIS_{name} = -1_c_int64_t")?,
            text if text.starts_with('"') => {
                writeln!(out, "  character(*), parameter :: MOLLIS_{name} = '{}'", text.trim_matches('"'))?;
            }
            number if number.parse::<i64>().is_ok() => {
                writeln!(out, "  integer(c_int32_t), parameter :: MOLLIS_{name} = {number}")?;
            }
            _ => {}
        }
    }
    Ok(())
}

fn structures(code: &str) -> Result<Vec<(String, Vec<Declared>)>> {
    let mut found = Vec::new();
    let mut rest = code;
    while let Some((_, after)) = rest.split_once("typedef struct ") {
        let (head, after) = after.split_once('{').context("a structure has no members")?;
        let (body, after) = after.split_once('}').context("a structure has no end")?;
        let members =
            body.split(';').filter(|member| !member.trim().is_empty()).map(declared).collect::<Result<_>>()?;
        found.push((head.trim().to_owned(), members));
        rest = after;
    }
    Ok(found)
}

fn functions(code: &str) -> Result<Vec<Function>> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices(");") {
        let start = code[..at].rfind([';', '}', '{']).map_or(0, |k| k + 1);
        let Some((head, arguments)) = code[start..at].split_once('(') else { continue };
        let head = head.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join(" ");
        let Some((result, name)) = head.trim().rsplit_once([' ', '*']) else { continue };
        if !name.starts_with("mollis_") || head.contains("typedef") {
            continue;
        }
        let arguments: Vec<&str> = arguments.split(',').map(str::trim).filter(|a| *a != "void").collect();
        let arguments = arguments.into_iter().map(declared).collect::<Result<_>>()?;
        let result = if head.contains('*') { "char *".to_owned() } else { result.trim().to_owned() };
        found.push(Function { name: name.to_owned(), result, arguments });
    }
    ensure!(!found.is_empty(), "the header has no function");
    Ok(found)
}

/// A declaration in C.
fn declared(text: &str) -> Result<Declared> {
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let to_function = text.contains(")(") || text.contains(") (");
    if to_function {
        let (_, after) = text.split_once("(*").with_context(|| format!("what is `{text}`?"))?;
        let name = after.split(')').next().unwrap_or_default().to_owned();
        let (kind, dimensions) = (String::new(), Vec::new());
        return Ok(Declared { name, kind, is_const: false, stars: 1, dimensions, to_array: false, to_function });
    }
    let to_array = text.contains("(*");
    let plain = text.replace("(*", " ").replace(')', "");
    let first = plain.find('[').unwrap_or(plain.len());
    let dimensions = plain[first..].split(['[', ']']).filter(|d| !d.is_empty()).map(str::to_owned).collect();
    let words = plain[..first].replace('*', " * ");
    let words: Vec<&str> = words.split_whitespace().collect();
    let (name, kind) = words.split_last().context("an empty declaration")?;
    let is_const = kind.contains(&"const");
    let stars = kind.iter().filter(|word| **word == "*").count() + usize::from(to_array);
    let kind =
        kind.iter().filter(|word| !["const", "struct", "*"].contains(word)).copied().collect::<Vec<_>>().join(" ");
    Ok(Declared { name: (*name).to_owned(), kind, is_const, stars, dimensions, to_array, to_function })
}

/// The type in Fortran of a number or a structure.
fn kind_of(kind: &str) -> Result<String> {
    Ok(match kind {
        "double" => "real(c_double)".into(),
        "float" => "real(c_float)".into(),
        "size_t" => "integer(c_size_t)".into(),
        "uint64_t" | "int64_t" => "integer(c_int64_t)".into(),
        "uint32_t" | "int32_t" | "mollis_status" => "integer(c_int32_t)".into(),
        "char" => "character(kind=c_char)".into(),
        name if name.starts_with("mollis_") => format!("type({name})"),
        other => bail!("mollis.f90 has no type for `{other}`"),
    })
}

fn member_of(member: &Declared) -> Result<String> {
    let shape = if member.dimensions.is_empty() || member.to_array {
        String::new()
    } else {
        format!("({})", member.dimensions.join(","))
    };
    let (kind, default) = if member.to_function {
        ("type(c_funptr)".to_owned(), "c_null_funptr")
    } else if member.stars > 0 {
        ("type(c_ptr)".to_owned(), "c_null_ptr")
    } else {
        (kind_of(&member.kind)?, "0")
    };
    if member.stars == 0 && member.kind.starts_with("mollis_") && member.kind != "mollis_status" {
        return Ok(format!("{kind} :: {}{shape}", member.name));
    }
    Ok(format!("{kind} :: {}{shape} = {default}", member.name))
}

impl Declared {
    fn is_memory(&self) -> bool {
        self.kind == "void"
    }

    fn is_structure(&self) -> bool {
        self.kind.starts_with("mollis_") && self.kind != "mollis_status"
    }

    fn is_optional(&self) -> bool {
        if self.stars == 0 || self.is_memory() {
            return false;
        }
        if self.is_structure() {
            return OPTIONAL.contains(&self.name.as_str())
                && (self.is_const || self.name == "report" || self.name == "counters");
        }
        !self.is_const && self.name != "bytes"
    }

    /// The lengths in Fortran's order.
    fn reversed(&self) -> String {
        self.dimensions.iter().rev().map(String::as_str).collect::<Vec<_>>().join(",")
    }

    /// The declaration of a dummy argument of the C function.
    fn dummy(&self) -> Result<String> {
        if self.is_memory() {
            return Ok(format!("type(c_ptr), value :: {}", self.name));
        }
        let kind = kind_of(&self.kind)?;
        if self.stars == 0 {
            return Ok(format!("{kind}, value :: {}", self.name));
        }
        let one = SCALARS.contains(&self.name.as_str()) && !self.is_const && !self.to_array;
        let shape = match (self.is_structure(), self.to_array) {
            (true, _) => {
                if ARRAYS.contains(&self.name.as_str()) {
                    "(*)".to_owned()
                } else {
                    String::new()
                }
            }
            (_, true) if POINTS.contains(&self.name.as_str()) => format!("({})", self.reversed()),
            (_, true) => format!("({},*)", self.reversed()),
            _ if one => String::new(),
            _ => "(*)".to_owned(),
        };
        let intent = if self.is_const { "in" } else { "inout" };
        // What a structure points to may be written although it is not itself: without the attribute compilers suppose that it is not.
        let target = if self.is_structure() { ", target" } else { "" };
        let optional = if self.is_optional() { ", optional" } else { "" };
        Ok(format!("{kind}, intent({intent}){target}{optional} :: {}{shape}", self.name))
    }
}

/// Writes a statement, continued where it is long.
fn statement(out: &mut String, indent: usize, text: &str) {
    let mut line = " ".repeat(indent);
    for (k, part) in text.split_inclusive(", ").enumerate() {
        if k > 0 && line.len() + part.len() + 2 > WIDTH {
            out.push_str(line.trim_end());
            out.push_str(" &\n");
            line = " ".repeat(indent + 4);
        }
        line.push_str(part);
    }
    out.push_str(line.trim_end());
    out.push('\n');
}

fn c_function(function: &Function, out: &mut String) -> Result<()> {
    let names: Vec<&str> = function.arguments.iter().map(|a| a.name.as_str()).collect();
    statement(out, 4, &format!("function {}({}) bind(c) result(answer)", function.name, names.join(", ")));
    out.push_str("      import\n");
    for argument in &function.arguments {
        statement(out, 6, &argument.dummy()?);
    }
    let result = if function.result == "char *" { "type(c_ptr)".to_owned() } else { kind_of(&function.result)? };
    writeln!(out, "      {result} :: answer\n    end function")?;
    Ok(())
}

/// Whether there is a subroutine for it: it returns a status.
fn has_thin_layer(function: &Function) -> bool {
    function.result == "mollis_status"
}

/// What is behind the prefix.
fn short(function: &Function) -> &str {
    function.name.trim_start_matches("mollis_")
}

/// The types of the arguments that tell two functions apart.
fn signature(function: &Function) -> Result<Vec<String>> {
    let required = function.arguments.iter().filter(|a| !a.is_optional() && !a.is_memory());
    required.map(|argument| kind_of(&argument.kind)).collect()
}

fn generics(functions: &[&Function], out: &mut String) -> Result<()> {
    let names: BTreeSet<&str> = functions.iter().map(|f| short(f)).collect();
    for function in functions {
        let (name, single) = (short(function), format!("{}_f32", short(function)));
        if let Some(other) = functions.iter().find(|f| short(f) == single)
            && signature(function)? != signature(other)?
        {
            write!(out, "\n  interface {name}\n    module procedure thin_{name}, thin_{single}\n  end interface\n")?;
        } else if !(name.ends_with("_f32") && names.contains(name.trim_end_matches("_f32")) && {
            let double = functions.iter().find(|f| short(f) == name.trim_end_matches("_f32")).context("no double")?;
            signature(double)? != signature(function)?
        }) {
            write!(out, "\n  interface {name}\n    module procedure thin_{name}\n  end interface\n")?;
        }
    }
    Ok(())
}

/// `mollis_at` is one name for functions over scalars and arrays of each rank. Dummies of assumed shape are passed where they are, gaps included, and have no
/// intent, as compilers take what is passed to `in` as never written through the address.
fn address_interface(out: &mut String) -> Result<()> {
    let names: Vec<String> = RANKS.map(|rank| format!("at_{rank}")).collect();
    let names = names.join(", ");
    write!(out, "\n  private :: {names}\n")?;
    write!(out, "\n  ! The address of the first element of a variable of any type.\n")?;
    write!(out, "  interface mollis_at\n    module procedure {names}\n  end interface\n")?;
    Ok(())
}

/// The form of `mollis_at` for one rank.
fn address_of_rank(rank: usize, out: &mut String) -> Result<()> {
    let shape = if rank == 0 { String::new() } else { format!("({})", vec![":"; rank].join(",")) };
    write!(out, "\n  function at_{rank}(x) result(address)\n    type(*), target :: x{shape}\n")?;
    write!(out, "    type(c_ptr) :: address\n    address = c_loc(x)\n  end function\n")?;
    Ok(())
}

/// The function as a subroutine.
fn subroutine(function: &Function, out: &mut String) -> Result<()> {
    let (mut dummies, mut declarations, mut actual) = (Vec::new(), Vec::new(), Vec::new());
    let mut texts = Vec::new();
    let mut arguments = function.arguments.iter().peekable();
    while let Some(argument) = arguments.next() {
        let name = &argument.name;
        if function.name.ends_with("_init") && argument.kind == "size_t" {
            // The size of the structure before it.
            actual.push(format!("c_sizeof({})", dummies.last().context("no structure")?));
        } else if argument.kind == "char" {
            arguments.next().context("a text has no length")?;
            dummies.push(name.clone());
            declarations.push(format!("character(*), intent(out) :: {name}"));
            declarations.push(format!("character(kind=c_char) :: c_{name}(len({name}) + 1)"));
            actual.push(format!("c_{name}"));
            actual.push(format!("size(c_{name}, kind=c_size_t)"));
            texts.push(name.clone());
        } else if argument.is_memory()
            && let Some(size) = arguments.next_if(|next| next.kind == "size_t" && next.stars == 0)
        {
            let _ = size;
            let intent = if argument.is_const { "in" } else { "inout" };
            dummies.push(name.clone());
            declarations.push(format!("integer(c_int8_t), intent({intent}), target, contiguous :: {name}(:)"));
            actual.push(format!("address_of({name})"));
            actual.push(format!("size({name}, kind=c_size_t)"));
        } else if argument.kind == "size_t" && argument.stars == 0 {
            dummies.push(name.clone());
            declarations.push(format!("integer, intent(in) :: {name}"));
            actual.push(format!("int({name}, c_size_t)"));
        } else {
            dummies.push(name.clone());
            declarations.push(argument.dummy()?);
            actual.push(name.clone());
        }
    }
    dummies.push("status".into());
    declarations.push("integer(c_int32_t), intent(out), optional :: status".into());
    out.push('\n');
    statement(out, 2, &format!("subroutine thin_{}({})", short(function), dummies.join(", ")));
    for declaration in &declarations {
        statement(out, 4, declaration);
    }
    for text in &texts {
        writeln!(out, "    c_{text} = c_null_char")?;
    }
    statement(out, 4, &format!("call tell({}({}), status)", function.name, actual.join(", ")));
    for text in &texts {
        writeln!(out, "    call fill({text}, c_{text})")?;
    }
    out.push_str("  end subroutine\n");
    Ok(())
}
