#pragma once

#include <ucontext.h>

#include <cstddef>
#include <functional>
#include <memory>

namespace simulation {

//! A function that runs on a stack of its own, on the caller's thread, and gives the word back with pause(). An
//! exception must not leave it, and it must not pause inside a catch block: the runtime keeps those per thread.
class Fiber
{
 public:
    Fiber();
    ~Fiber();
    Fiber(Fiber const&) = delete;
    Fiber& operator=(Fiber const&) = delete;

    void start(std::function<void()> body);  //!< to be entered by resume(); the stack of an ended one is used again
    void resume();                           //!< runs it until it pauses or ends
    void pause();                            //!< called inside: back to who resumed it
    bool ended() const { return ended_; }

 private:
    static void enter(unsigned low, unsigned high);
    void run();

    static constexpr std::size_t stack_size = 256 * 1024;  // bytes; a session's deepest call takes a tenth
    std::unique_ptr<std::byte[]> stack_;
    std::function<void()> body_;
    ucontext_t here_{}, caller_{};
    bool ended_ = true;
    void const* caller_stack_ = nullptr;  //!< for AddressSanitizer
    std::size_t caller_size_ = 0;
};

}  // namespace simulation
