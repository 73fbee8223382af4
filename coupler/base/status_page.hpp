#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

namespace sluice {

enum class Phase : std::int32_t
{
    absent = 0,
    preparing,
    connecting,
    running,
    done,
    failed
};

//! What a user may ask of a run while it goes on.
enum class Request : std::int32_t
{
    checkpoint = 1,  //!< store the state
    stop = 2         //!< and stop then; without a state to store, stop at the next window's begin
};

//! A small file in the run's directory that a participant maps and keeps up to date at no cost, and that `sluice run`
//! reads: progress, and after a failure who stopped where and why. Each participant writes its own page only.
struct StatusPage
{
    std::atomic<std::int32_t> pid{0};
    std::atomic<Phase> phase{Phase::absent};
    std::atomic<std::int64_t> window{0};
    std::atomic<std::int64_t> windows{0};
    std::atomic<std::int64_t> compute_ns{0};
    std::atomic<std::int64_t> wait_ns{0};
    std::atomic<std::int64_t> exchange_ns{0};
    std::atomic<double> time{0};               //!< simulated seconds
    std::atomic<std::int32_t> exit{-1};        //!< exit code, once known
    std::atomic<std::int32_t> consequence{0};  //!< 1: it stopped because another one did
    std::atomic<std::int32_t> request{0};      //!< bits of Request, set by `sluice`, taken by the participant
    std::atomic<std::int32_t> can_store{0};    //!< 1: its state can be stored
    std::atomic<std::int64_t> checkpoint{-1};  //!< window of the newest complete checkpoint that it knows of
    char note[256] = {};                       //!< what it does now, e.g. "settling the packing"
    char message[16384] = {};                  //!< why it failed
};

//! A mapped page; unmapped on destruction. Throws Error (exit 7) if it cannot be made.
class MappedStatus
{
 public:
    enum class Mode
    {
        create,   //!< a new page
        open,     //!< one that is there and whole, else empty
        unshared  //!< in memory, for nobody else to see
    };
    MappedStatus(std::filesystem::path const& file, Mode mode);
    MappedStatus(MappedStatus&& other) noexcept : page_(std::exchange(other.page_, nullptr)) {}
    MappedStatus& operator=(MappedStatus&& other) noexcept
    {
        std::swap(page_, other.page_);
        return *this;
    }
    ~MappedStatus();

    explicit operator bool() const { return page_ != nullptr; }
    StatusPage* operator->() const { return page_; }
    void note(std::string_view text);
    void fail(std::string_view message, int exit, bool consequence);

 private:
    StatusPage* page_ = nullptr;
};

//! Set by a launcher whose child starts the participants (mpirun): they then end with that child.
inline constexpr char const* parent_death = "SLUICE_END_WITH_PARENT";

//! Set by `sluice record`: every process writes the frames that it sends to RUN/recordings/NAME.rec.
inline constexpr char const* record_frames = "SLUICE_RECORD";

inline std::filesystem::path status_file(std::filesystem::path const& directory, std::string const& participant)
{
    return directory / ".sluice" / (participant + ".status");
}

}  // namespace sluice
