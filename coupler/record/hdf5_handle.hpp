#pragma once

#include <hdf5.h>

#include <string>
#include <utility>

namespace sluice::hdf5 {

//! Keeps HDF5 quiet on this thread (it prints its error stack by default) and restores its habit at the end.
class Quiet
{
 public:
    Quiet();
    Quiet(Quiet const&) = delete;
    Quiet& operator=(Quiet const&) = delete;
    ~Quiet();

 private:
    H5E_auto2_t function_ = nullptr;
    void* data_ = nullptr;
};

//! Call before the first use of HDF5: forbids its clean-up at exit, which writes to files that failed before and then
//! crashes (1.10.8, disk full). We close every file ourselves.
void forbid_exit_handler();

//! The innermost reason on HDF5's error stack, e.g. "No space left on device".
std::string reason();

//! An HDF5 id; `close()` reports, the destructor does not.
class Handle
{
 public:
    using Close = herr_t (*)(hid_t);
    //! Throws Error (Exit::io) with `what` and HDF5's reason when `id` is negative.
    Handle(hid_t id, Close close, std::string const& what);
    Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    Handle& operator=(Handle&&) = delete;
    ~Handle()
    {
        if (id_ >= 0) close_(id_);
    }
    hid_t get() const noexcept { return id_; }
    void close(std::string const& what);

 private:
    hid_t id_;
    Close close_;
};

//! Throws Error (Exit::io) with `what` and HDF5's reason when `status` is negative.
void check(herr_t status, std::string const& what);

}  // namespace sluice::hdf5
