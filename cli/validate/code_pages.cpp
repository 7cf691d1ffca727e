// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/code_pages.cpp
#include "validate/code_pages.h"

#include <fmt/format.h>

#include "model/codes.h"

namespace dgm::validate {
namespace {

std::string upper_case(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    return out;
}

}  // namespace

const model::Code* find_code(std::string_view name) {
    const std::string wanted = upper_case(name);
    for (const model::Code* code : model::codes::kAll)
        if (wanted == code->id() || wanted == std::to_string(code->number) || wanted == code->name ||
            wanted == code->id() + "_" + code->name)
            return code;
    return nullptr;
}

const char* subject_of(const model::Code& code) {
    switch (code.number / 1000) {
        case 1:
            return "container and index";
        case 2:
            return "layers and their values";
        case 3:
            return "source mesh and bake";
        case 4:
            return "reconstruction against source";
        case 5:
            return "files and system";
        case 6:
            return "usage";
        default:
            return "internal";
    }
}

std::string explain(const model::Code& code) {
    return fmt::format("{} {} ({})\n  what: {}\n  why:  {}\n  next: {}\n  exit: {}\n", code.id(), code.name,
                       subject_of(code), code.title, code.why, code.hint, static_cast<int>(code.exit));
}

std::string explain_all() {
    std::string out;
    for (const model::Code* code : model::codes::kAll) out += (out.empty() ? "" : "\n") + explain(*code);
    return out;
}

std::string codes_markdown() {
    std::string out =
        "<!-- SPDX-License-Identifier: GPL-3.0-or-later -->\n"
        "# Codes\n\n"
        "Every finding and failure of the tools has a number that never changes its meaning. `dgm-validate --explain "
        "CODE`\n"
        "prints one of them; `dgm-validate --explain all --format markdown` writes this page, and a test checks "
        "that.\n"
        "The last column is the exit code of a program that ends with it as an error.\n";
    const char* subject = "";
    for (const model::Code* code : model::codes::kAll) {
        if (std::string_view(subject) != subject_of(*code)) {
            subject = subject_of(*code);
            out += fmt::format(
                "\n## {}xxx {}\n\n| code | what | why it matters | what to do | exit |\n|---|---|---|---|---|\n",
                code->number / 1000, subject);
        }
        out += fmt::format("| {}<br>`{}` | {} | {} | {} | {} |\n", code->id(), code->name, code->title, code->why,
                           code->hint, static_cast<int>(code->exit));
    }
    return out;
}

}  // namespace dgm::validate
