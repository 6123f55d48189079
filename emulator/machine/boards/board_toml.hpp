#pragma once
// What the readers of a board file share (docs/boards.md).

#include "io/toml_reader.hpp"
#include "machine/boards/board_file.hpp"

namespace machine {

class BoardToml : public io::TomlReader {
 public:
  using TomlReader::TomlReader;

  /// Every region could be read. Only then an error reports a device outside all regions.
  bool regions_known = true;

  /// The files that the board file names are read.
  bool reads_files = true;

  c40::Word word(const toml::node& node, std::string_view key, std::int64_t most = 0xFFFFFFFF) {
    return static_cast<c40::Word>(whole(node, key, 0, most));
  }
};

/// [[device]] tables, to be read after the regions. Adds the devices to the board.
void read_devices(BoardToml& toml, BoardDescription& board, const toml::table& root);

}  // namespace machine
