/// Writes files, for all subcommands, and turns JSON into text.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace edge_mcl {

/// The content as indented text. Bytes that are not UTF-8 (in names of files) become replacement
/// characters.
std::string textOf(const nlohmann::json& content);

/// Writes FILE.part and then renames it to FILE, so that a file with the final name is complete. A
/// device or a pipe is written to directly. @throws InputError when the file cannot be written
void writeJson(const std::string& file, const nlohmann::json& content);
/// @throws InputError when the file cannot be written
void writeText(const std::string& file, const std::string& text);
/// Creates a directory and its parents. @throws InputError when it cannot be created
void makeDirectory(const std::string& directory);

/// Checks that a file can be written. To be called before long work. An empty name means: no file.
/// @throws InputError when the file cannot be written
void checkOutput(const std::string& file);
/// The same for a picture, whose format must be one that can be written.
void checkPicture(const std::string& file);

}  // namespace edge_mcl
