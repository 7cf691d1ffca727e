# SPDX-License-Identifier: GPL-3.0-or-later
# cmake -DOUT=FILE.cpp -DPAGE=FOLDER -DD3=d3.min.js -P embed_page.cmake: the page's parts as constants of html_page.h.
# File names and text may hold anything but the raw string's closing mark.
set(text "// Made by embed_page.cmake\n#include \"bench/html_page.h\"\nnamespace dgm::bench::page {\n")
foreach(part "kHtml|${PAGE}/page.html" "kCss|${PAGE}/page.css" "kScript|${PAGE}/page.js" "kD3|${D3}")
  string(REPLACE "|" ";" part "${part}")
  list(GET part 0 name)
  list(GET part 1 file)
  file(READ "${file}" content)
  string(FIND "${content}" ")dgm_page\"" clash)
  if(NOT clash EQUAL -1)
    message(FATAL_ERROR "${file} holds the mark that ends its raw string")
  endif()
  string(APPEND text "const char* const ${name} = R\"dgm_page(${content})dgm_page\";\n")
endforeach()
string(APPEND text "}  // namespace dgm::bench::page\n")
file(WRITE "${OUT}" "${text}")
