/// Files that several subcommands write, and JSON as text.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace edge_mcl {

/// Indented; names that are not UTF-8 get marks of replacement.
std::string textOf(const nlohmann::json& content);

/// As FILE.part first, so that what has the name is whole.
/// @throws InputError when it cannot be written; likewise below.
void writeJson(const std::string& file, const nlohmann::json& content);
void makeDirectory(const std::string& directory);

/// Whether a file can be written later, after long work; an empty name is none.
void checkOutput(const std::string& file);

}  // namespace edge_mcl
