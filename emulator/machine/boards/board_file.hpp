#pragma once
// Boards by name, or from TOML files (docs/boards.md): for a single program, and for the DSPs of the dock.
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "c40/chip/board.hpp"
#include "c40/observers/probe.hpp"
#include "io/text_error.hpp"
#include "machine/boards/board_device.hpp"
#include "machine/system/symbols.hpp"

namespace toolchain {
struct Image;
}

namespace machine {

/// A board that cannot be used. The message names the file and line, or the board, the key and what would be right.
class BoardError : public io::TextError<std::invalid_argument> {
 public:
  using TextError::TextError;
};

/// Limits of CLKIN.
inline constexpr double slowest_mhz = 0.001, fastest_mhz = 1000;

/// The surroundings of a chip, and what a board file says about the chip itself.
struct BoardDescription {
  c40::Board board;
  std::optional<double> clock_mhz{};  ///< CLKIN; an H1 period is two of its periods.
  bool has_pins = false;              ///< The board file says how pins are tied, and whether the boot ROM is there.
  std::vector<DeviceDescription> devices{};  ///< behind its windows
  /// Initial contents of regions: images of ROMs.
  struct Contents {
    c40::Address base = 0;
    std::vector<c40::Word> words;
  };
  std::vector<Contents> contents{};
  std::vector<std::string> warnings{};  ///< what a user should know: file, line, and what is doubtful
  std::vector<c40::AddressRange>
      ignored{};  ///< addresses without memory at which an access is not a fault (board_reserved.hpp)
};

/// "default", "flat", or a TOML file. \throws BoardError
/// \param files whether to read the files that the board file names, ROMs and inputs; not needed for the registers
/// alone
enum class BoardFiles : std::uint8_t { read, leave };
BoardDescription read_board(const std::string& name, BoardFiles files = BoardFiles::read);

/// The input of a device's other side. \throws std::invalid_argument with file, line and what would be right
/// \param script false: a console's plain characters, a FIFO's words in hexadecimal
DeviceInput device_input(std::string text, const std::string& source, DeviceKind kind, bool script);
DeviceInput read_device_input(const std::string& path, DeviceKind kind, bool script);

/// For the dock, whose chips have no devices of their own. \throws BoardError
void refuse_devices(const BoardDescription& board, std::string_view where);
/// For the dock, whose DSPs stop at reserved addresses. \throws BoardError
void refuse_ignored(const BoardDescription& board);

/// H1 periods per second.
std::int64_t instruction_cycles_per_second(double clock_mhz);

/// Checks that the machine's DSPs can use this board: windows to buses A and B only where the program expects them, and
/// RAM for each of the program's sections. \throws BoardError
void require_dsp_board(const c40::Board& board, const toolchain::Image& program, const Symbols& symbols);

}  // namespace machine
