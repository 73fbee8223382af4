#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

//! How the coupling benchmark sees what it measures.
namespace bench {

constexpr std::size_t point_size = 32;  //!< bytes: an id (8 bytes) and three doubles

//! What two processes know before they part, to find each other.
struct Setting
{
    int side = 0;                          //!< 0 times, 1 answers
    std::filesystem::path directory = {};  //!< for sockets
    int port = 0;                          //!< on loopback; this one and the 20 that follow
    std::span<std::byte> arena = {};       //!< memory that both processes have
    std::size_t most_points = 0;
};

//! A way for two processes to exchange the data of points. Both sides make it and call it alike.
class Way
{
 public:
    virtual ~Way() = default;
    //! Side 0 sends `points` points and takes in as many; side 1 the other way round.
    virtual void round_trip(std::size_t points) = 0;
    //! Waits for a message that does not come.
    virtual void wait_in_vain(double /*seconds*/) {}
};

using MakeWay = std::unique_ptr<Way> (*)(Setting const&);

//! What a solver sends from and copies to.
struct Field
{
    explicit Field(std::size_t most_points) : bytes(most_points * point_size)
    {
        for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = std::byte(i * 7);
    }
    std::span<std::byte> of(std::size_t points) { return std::span(bytes).first(points * point_size); }
    std::vector<std::byte> bytes;
};

}  // namespace bench
