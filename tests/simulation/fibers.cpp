#include "tests/simulation/fibers.hpp"

#include <cassert>
#include <cstdint>

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/common_interface_defs.h>
#endif

namespace simulation {
namespace {

// AddressSanitizer must be told which stack is in use.
void leaving(void** fake, void const* stack, std::size_t size)
{
#ifdef __SANITIZE_ADDRESS__
    __sanitizer_start_switch_fiber(fake, stack, size);
#else
    (void)fake, (void)stack, (void)size;
#endif
}

void arrived(void* fake, void const** from, std::size_t* size)
{
#ifdef __SANITIZE_ADDRESS__
    __sanitizer_finish_switch_fiber(fake, from, size);
#else
    (void)fake, (void)from, (void)size;
#endif
}

}  // namespace

Fiber::Fiber() : stack_(new std::byte[stack_size]) {}

Fiber::~Fiber()
{
    assert(ended_);
}

void Fiber::start(std::function<void()> body)
{
    assert(ended_);
    body_ = std::move(body);
    ended_ = false;
    getcontext(&here_);
    here_.uc_stack.ss_sp = stack_.get();
    here_.uc_stack.ss_size = stack_size;
    here_.uc_link = nullptr;
    auto const self = reinterpret_cast<std::uintptr_t>(this);  // makecontext passes integers
    makecontext(&here_, reinterpret_cast<void (*)()>(&Fiber::enter), 2, static_cast<unsigned>(self),
                static_cast<unsigned>(self >> 32));
}

void Fiber::enter(unsigned low, unsigned high)
{
    reinterpret_cast<Fiber*>(std::uintptr_t{low} | std::uintptr_t{high} << 32)->run();
}

void Fiber::run()
{
    arrived(nullptr, &caller_stack_, &caller_size_);
    body_();
    ended_ = true;
    leaving(nullptr, caller_stack_, caller_size_);
    setcontext(&caller_);
}

void Fiber::resume()
{
    void* fake = nullptr;
    leaving(&fake, stack_.get(), stack_size);
    swapcontext(&caller_, &here_);
    arrived(fake, nullptr, nullptr);
}

void Fiber::pause()
{
    void* fake = nullptr;
    leaving(&fake, caller_stack_, caller_size_);
    swapcontext(&here_, &caller_);
    arrived(fake, &caller_stack_, &caller_size_);
}

}  // namespace simulation
