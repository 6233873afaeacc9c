#!/usr/bin/env python3
"""Checks that each source includes the standard headers that it uses, itself or by its own header.

tools/includes.py          lists each file with the headers that it lacks; exits with 1 if any does
tools/includes.py --fix    adds them; clang-format then sorts them
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).parents[1]
FOLDERS = ("include", "src", "app", "python", "paper", "bench", "examples")

# Header: the names of namespace std that it declares. Names of several headers, such as std::get,
# are left out.
NAMES = {
    "algorithm": "all_of any_of none_of binary_search clamp copy copy_if copy_n count count_if equal "
                 "fill fill_n find find_if find_if_not for_each generate is_sorted "
                 "lexicographical_compare lower_bound max max_element min min_element minmax "
                 "minmax_element nth_element partial_sort partition remove_if replace reverse rotate "
                 "search shuffle sort stable_partition stable_sort swap_ranges transform unique "
                 "upper_bound",
    "array": "array to_array",
    "atomic": "atomic atomic_ref memory_order_acquire memory_order_relaxed memory_order_release "
              "memory_order_seq_cst",
    "bit": "bit_cast bit_ceil bit_width countl_zero countr_zero endian has_single_bit popcount",
    "bitset": "bitset",
    "charconv": "chars_format from_chars to_chars",
    "chrono": "chrono",
    "cmath": "acos asin atan atan2 cbrt ceil cos erf erfc exp exp2 floor fma fmod hypot isfinite isinf "
             "isnan lerp llround log log10 log1p log2 lround nan nanf pow remainder rint round sin "
             "sqrt tan trunc",
    "complex": "complex polar",
    "concepts": "convertible_to derived_from floating_point integral invocable same_as",
    "condition_variable": "condition_variable condition_variable_any",
    "cstddef": "byte max_align_t nullptr_t ptrdiff_t size_t",
    "cstdint": "int8_t int16_t int32_t int64_t uint8_t uint16_t uint32_t uint64_t uintptr_t",
    "cstdio": "FILE fclose fflush fopen fprintf fputs fread fwrite printf snprintf",
    "cstdlib": "_Exit abort exit free getenv malloc strtod strtol strtoull",
    "cstring": "memchr memcmp memcpy memmove memset strcmp strerror strlen",
    "ctime": "time_t",
    "deque": "deque",
    "exception": "current_exception exception exception_ptr make_exception_ptr rethrow_exception "
                 "terminate uncaught_exceptions",
    "filesystem": "filesystem",
    "fstream": "fstream ifstream ofstream",
    "functional": "bind_front cref equal_to function greater hash identity invoke less multiplies "
                  "not_fn plus ref reference_wrapper",
    "future": "async future future_status launch packaged_task promise",
    "initializer_list": "initializer_list",
    "iostream": "cerr cin cout",
    "iterator": "advance back_inserter distance istream_iterator istreambuf_iterator "
                "make_move_iterator next prev ssize",
    "limits": "numeric_limits",
    "map": "map multimap",
    "memory": "addressof enable_shared_from_this make_shared make_unique shared_ptr "
              "static_pointer_cast unique_ptr weak_ptr",
    "mutex": "call_once lock_guard mutex once_flag recursive_mutex scoped_lock unique_lock",
    "new": "align_val_t bad_alloc",
    "numbers": "numbers",
    "numeric": "accumulate exclusive_scan gcd inclusive_scan inner_product iota lcm midpoint "
               "partial_sum reduce transform_reduce",
    "optional": "make_optional nullopt nullopt_t optional",
    "queue": "priority_queue queue",
    "random": "mt19937 mt19937_64 normal_distribution random_device uniform_int_distribution "
              "uniform_real_distribution",
    "ranges": "views",
    "regex": "cmatch regex regex_match regex_replace regex_search smatch sregex_iterator",
    "set": "multiset set",
    "shared_mutex": "shared_lock shared_mutex",
    "span": "as_bytes dynamic_extent span",
    "sstream": "istringstream ostringstream stringstream",
    "stdexcept": "invalid_argument length_error logic_error out_of_range runtime_error",
    "stop_token": "stop_callback stop_source stop_token",
    "string": "getline stod stoi stol stoul stoull string to_string",
    "string_view": "string_view",
    "system_error": "errc error_code generic_category system_category system_error",
    "thread": "jthread this_thread thread",
    "tuple": "apply forward_as_tuple ignore make_tuple tie tuple tuple_size_v",
    "type_traits": "common_type_t conditional_t decay_t enable_if_t false_type invoke_result_t "
                   "is_arithmetic_v is_const_v is_convertible_v is_enum_v is_floating_point_v "
                   "is_integral_v is_invocable_v is_same_v is_signed_v is_unsigned_v "
                   "make_signed_t make_unsigned_t remove_const_t remove_cvref_t "
                   "remove_reference_t true_type underlying_type_t",
    "unordered_map": "unordered_map",
    "unordered_set": "unordered_set",
    "utility": "as_const cmp_equal cmp_greater cmp_less cmp_less_equal declval exchange forward "
               "in_place in_place_t index_sequence integer_sequence make_index_sequence make_pair "
               "move pair swap",
    "variant": "get_if holds_alternative monostate variant variant_alternative_t visit",
    "vector": "vector",
}
HEADER_OF = {name: header for header, names in NAMES.items() for name in names.split()}

# std::size_t, std::move and std::pair come with each of these, whose interfaces have them.
WITH_BASICS = {"algorithm", "array", "deque", "functional", "map", "memory", "optional", "set", "span",
               "string", "string_view", "tuple", "unordered_map", "variant", "vector"}
BASICS = {"cstddef", "utility"}

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"]', re.M)
COMMENT_OR_TEXT = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"([^()\\ ]{0,16})\(.*?\)\1"|"(?:\\.|[^"\\\n])*"', re.S)
USED = re.compile(r"\bstd::(ranges::)?(\w+)")


def sources():
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".h", ".cpp") and "build" not in path.parts:
                yield path


def own_header(path):
    """The header that a source or an -inl.h completes: the first that it includes with its name."""
    if path.suffix == ".h":
        return None
    for bracket, name in INCLUDE.findall(path.read_text()):
        if bracket == '"' and pathlib.PurePath(name).stem == path.stem:
            for folder in (ROOT / "include", ROOT / "src", ROOT):
                if (folder / name).exists():
                    return folder / name
    return None


def included(path):
    return {name for bracket, name in INCLUDE.findall(path.read_text()) if bracket == "<"}


def used(path):
    headers = set()
    for of_ranges, name in USED.findall(COMMENT_OR_TEXT.sub(" ", path.read_text())):
        if of_ranges:
            headers.add({"distance": "iterator", "next": "iterator", "greater": "functional",
                         "less": "functional", "equal_to": "functional"}.get(name, "")
                        or ("algorithm" if HEADER_OF.get(name) == "algorithm" else ""))
        else:
            headers.add(HEADER_OF.get(name, ""))
    return headers - {""}


def lacking(path):
    there = included(path)
    header = own_header(path)
    if header:
        there |= included(header)

    missing = used(path) - there
    if (there | missing) & WITH_BASICS:
        missing -= BASICS
    return sorted(missing)


def fix(path, headers):
    """Adds them to the first group of standard headers; a file without one gets one."""
    lines = path.read_text().split("\n")
    new = [f"#include <{header}>" for header in headers]
    standard = [i for i, line in enumerate(lines) if re.match(r"#include <[a-z_]+>$", line)]
    if standard:
        lines[standard[0]:standard[0]] = new
    else:
        first = next(i for i, line in enumerate(lines) if line.startswith(("#include", "#pragma once")))
        after = first + 1 if lines[first].startswith("#pragma") or own_header(path) else first
        lines[after:after] = ["", *new, ""] if after > first else [*new, ""]
    path.write_text("\n".join(lines))


def main():
    found = {path: headers for path in sources() if (headers := lacking(path))}
    for path, headers in found.items():
        if "--fix" in sys.argv:
            fix(path, headers)
        else:
            print(f"{path.relative_to(ROOT)} lacks {', '.join(f'<{name}>' for name in headers)}")
    return 1 if found and "--fix" not in sys.argv else 0


if __name__ == "__main__":
    sys.exit(main())
