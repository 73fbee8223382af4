//! RecordingReader: never more bytes than the file has, and an end that is one or the other.
#include "coupler/base/error.hpp"
#include "coupler/record/recording.hpp"
#include "tests/fuzz/target.hpp"

using namespace sluice;

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    fuzz::MemoryFile const file({data, size});
    try {
        RecordingReader reader(file.path());
        std::size_t bytes = reader.canonical().size();
        while (auto const record = reader.next()) bytes += record->bytes.size();
        fuzz::demand(bytes < size, "records are no longer than their file");
        fuzz::demand(reader.end() != RecordingReader::End::not_yet, "a recording ends");
        fuzz::accepted += reader.end() == RecordingReader::End::closed;
    } catch (Error const& error) {
        fuzz::demand(error.exit() == Exit::io && std::string(error.what()).starts_with(file.path() + ": "),
                     "an Error says where", error.what());
    }
    return 0;
}
