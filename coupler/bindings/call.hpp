#pragma once

#include <new>
#include <string>

#include "coupler/base/error.hpp"

//! From exceptions to statuses: what every function of the C interface does around its one call.
namespace sluice::bindings {

struct Failure
{
    std::string text;
    int status = 0;
};
inline thread_local Failure last_failure;  //!< of any call

inline int note(std::string const& text, sluice::Exit exit) noexcept
{
    try {
        last_failure.text = text;
    } catch (...) {  // out of memory: the code has to do
        last_failure.text.clear();
    }
    return last_failure.status = static_cast<int>(exit);
}

//! The status of `work`: 0, or that of the exception that it ended with.
template <class Work>
int status_of(Work&& work) noexcept
{
    try {
        work();
        return 0;
    } catch (sluice::Error const& e) {
        return note(e.what(), e.exit());
    } catch (std::bad_alloc const&) {
        return note("out of memory. Make the scene smaller.", sluice::Exit::io);
    } catch (std::exception const& e) {
        return note(std::string(e.what()) + " (a bug of ours).", sluice::Exit::internal);
    } catch (...) {
        return note("an exception of unknown kind (a bug of ours).", sluice::Exit::internal);
    }
}

//! A call that is wrong, which a program in C++ would not compile or would be told by an assert.
[[noreturn]] inline void misuse(std::string const& text)
{
    throw sluice::Error("sluice_" + text, sluice::Exit::internal);
}

inline void require_given(void const* pointer, char const* what)
{
    if (!pointer) misuse(std::string(what) + " is NULL (needed).");
}

template <class T>
T& needed(T* pointer, char const* what)
{
    require_given(pointer, what);
    return *pointer;
}

}  // namespace sluice::bindings
