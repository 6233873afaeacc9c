# cmake -D SOURCE=... -D VERSION=... -D FILE=... -P version.cmake: writes the program's version, with
# the commit where there is one, where the file does not say it already. The mark is in a section of
# its own, where another program finds it: see whole_program.h.
cmake_minimum_required(VERSION 3.22)
execute_process(COMMAND git describe --always --dirty --exclude=* --abbrev=9
  WORKING_DIRECTORY ${SOURCE} OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(commit AND EXISTS ${SOURCE}/.git)
  string(APPEND VERSION "+g${commit}")
endif()
file(CONFIGURE OUTPUT ${FILE} CONTENT "namespace slipstream::app {
extern const char* const program_version;
const char* const program_version = \"@VERSION@\";
extern const char program_mark[];
[[gnu::used, gnu::section(\".slipstream\")]] const char program_mark[] = \"slipstream @VERSION@\";
}
" @ONLY)
