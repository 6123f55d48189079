#pragma once
// Reads rows of [[processes]] and [[subprocesses]]; for the files that use TOML.
#include <toml++/toml.h>

#include <string>

#include "cmrc/configuration/rows/process_table.hpp"

namespace cmrc {

/// Replaces the rows of the same numbers in `table`. \param name of the file \param errors of the rows are added to it
/// \throws ConfigError if there are no rows
void read_processes(const toml::node& rows, const std::string& name, ProcessTable& table, ConfigErrors& errors);
void read_subprocesses(const toml::node& rows, const std::string& name, ProcessTable& table, ConfigErrors& errors);

}  // namespace cmrc
