#pragma once

#include <array>
#include <vector>

#include "coupler/transport/buffer.hpp"
#include "coupler/transport/transport.hpp"
#include "coupler/wire/message.hpp"

//! The data that fuzz_frame decodes, and the frame before the one it makes up.
namespace sluice::fuzz {

inline DataSpec const load{"load", {{"force", Shape::vector, "N"}, {"torque", Shape::spin, "N m"}}, false, false};
constexpr int dimension = 2;

struct Sample
{
    std::int64_t index = 0;
    std::vector<std::int64_t> ids{3, 5};
    std::vector<double> force{1, 2, 3, 4}, torque{5, 6};
};

//! The bytes of a frame, in memory of their own.
inline sluice::Message encoded(FrameEncoder& encoder, Sample const& frame)
{
    auto const buffer = std::make_shared<Buffer>();
    auto const room = buffer->room(encoder.bound(frame.ids.size()));
    std::array<std::span<double const>, 2> const columns{frame.force, frame.torque};
    return {room.first(encoder.encode({frame.index, 0, 0, frame.ids, columns}, 1, "a", room)), buffer};
}

}  // namespace sluice::fuzz
