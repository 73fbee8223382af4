//! open_message and FrameDecoder, after one good frame: what is taken has columns that fit its points.
#include <cstring>

#include "coupler/base/error.hpp"
#include "tests/fuzz/frames.hpp"
#include "tests/fuzz/target.hpp"

using namespace sluice;

namespace {

FrameDecoder decoder_with_one_frame()
{
    FrameEncoder encoder(fuzz::load, fuzz::dimension, 0);
    FrameDecoder decoder(fuzz::load, fuzz::dimension);
    auto const message = fuzz::encoded(encoder, {});
    decoder.decode(open_message(message.bytes, "a"), message.bytes, message.owner, "a");
    return decoder;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(std::uint8_t const* data, std::size_t size)
{
    static FrameDecoder const start = decoder_with_one_frame();
    auto const owner = std::make_shared<Bytes>(size);
    auto& message = *owner;
    if (size > 0) std::memcpy(message.data(), data, size);
    auto const body = static_cast<std::uint64_t>(size) - sizeof(Header);  // the length it states is made right
    if (size >= sizeof(Header)) std::memcpy(message.data() + offsetof(Header, body), &body, sizeof body);
    FrameDecoder decoder = start;
    try {
        auto const header = open_message(message, "input");
        if (header.kind != MessageKind::frame) return 0;
        auto const frame = decoder.decode(header, message, owner, "input");
        fuzz::demand(frame.columns.size() == fuzz::load.columns.size(), "a frame has its data's columns");
        for (std::size_t c = 0; c < frame.columns.size(); ++c)
            fuzz::demand(
                frame.columns[c].values.size() ==
                    frame.points() * static_cast<std::size_t>(components(fuzz::load.columns[c].shape, fuzz::dimension)),
                "a column has values for every point");
        ++fuzz::accepted;
    } catch (Error const& error) {
        fuzz::demand(error.exit() == Exit::protocol, "a wrong message is one of exit code 5", error.what());
    }
    return 0;
}
