#pragma once
// Images of read-only memories in the formats of EPROM programmers: plain bytes, Intel hex, Motorola S-records.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_error.hpp"
#include "isa/word.hpp"

namespace toolchain {

enum class RomFormat : std::uint8_t { binary, intel_hex, srec };

/// "ROM.hex:3: the checksum is 4Fh; 50h is expected"
class RomError : public io::TextError<std::runtime_error> {
 public:
  using TextError::TextError;
};

/// The file's text, from address 0 on.
std::string rom_file(std::span<const std::uint8_t> bytes, RomFormat format);

/// The bytes from the lowest address of the file on, gaps filled with FFh. The file's contents show its format. \throws
/// RomError
std::vector<std::uint8_t> read_rom(const std::filesystem::path& path);

/// The words of such a file, in memory of `width` bits; without `width` the file says it, as it does to a boot loader.
/// \param width_name who is asked for the width where neither says it: an option or a key
/// \throws RomError: also where the file ends within a word
std::vector<isa::Word> read_rom_words(const std::filesystem::path& path, std::optional<unsigned> width,
                                      std::string_view width_name);
/// The same of a file that has been read.
std::vector<isa::Word> rom_words_of(const std::filesystem::path& path, std::span<const std::uint8_t> bytes,
                                    std::optional<unsigned> width, std::string_view width_name);

/// What a warning says of a given width that the file's first word contradicts: the given one holds. Empty: it does
/// not.
std::string width_contradiction(std::span<const std::uint8_t> bytes, std::optional<unsigned> width,
                                std::string_view width_name);

/// What lies in memory that is 8, 16 or 32 bits wide, by rising address: the lowest byte of a word comes first.
std::vector<isa::Word> rom_words(std::span<const std::uint8_t> bytes, unsigned width);
std::vector<std::uint8_t> rom_bytes(std::span<const isa::Word> words);
/// The width at the beginning of a boot stream for memory: 8, 16 or 32; none: the bytes are not such a stream.
std::optional<unsigned> boot_width(std::span<const std::uint8_t> bytes);

}  // namespace toolchain
