// What a solver keeps, for C.

#include "coupler/bindings/handle.hpp"

struct sluice_state
{
    sluice::State* saved = nullptr;           //!< in `save`
    sluice::State const* restored = nullptr;  //!< in `restore`
};

namespace sluice::bindings {
namespace {

template <class T>
std::span<T const> values_of(void const* values, std::size_t size)
{
    if (size > 0) require_given(values, "put: values");
    return {static_cast<T const*>(values), size};
}

//! `callback` of the solver, whose failure becomes that of the call around it.
void run_callback(int (*callback)(void*, sluice_state*), void* context, sluice_state state, char const* what)
{
    last_failure = {};
    int const status = callback(context, &state);
    if (status == 0) return;
    throw sluice::Error(
        last_failure.text.empty() ? "the solver could not " + std::string(what) + " its state." : last_failure.text,
        static_cast<sluice::Exit>(status));
}

}  // namespace
}  // namespace sluice::bindings

using namespace sluice::bindings;

extern "C" {

int sluice_keeps(sluice_participant* self, int (*save)(void*, sluice_state*), int (*restore)(void*, sluice_state*),
                 void* context)
{
    return call(self, "keeps", [&] {
        if (!save || !restore) misuse("keeps: save or restore is NULL (both are needed).");
        self->self.keeps(
            [=](sluice::State& state) {
                run_callback(save, context, {&state, nullptr}, "save");
            },
            [=](sluice::State const& state) {
                run_callback(restore, context, {nullptr, &state}, "restore");
            });
    });
}

int sluice_put(sluice_state* state, char const* name, int type, void const* values, size_t size)
{
    return status_of([&] {
        auto& saved = needed(needed(state, "put: state").saved, "put: the state is being restored; its saved part");
        std::string const key = &needed(name, "put: name");
        if (type == SLUICE_FLOAT64)
            saved.put(key, values_of<double>(values, size));
        else if (type == SLUICE_INT64)
            saved.put(key, values_of<std::int64_t>(values, size));
        else if (type == SLUICE_BYTES)
            saved.put(key, values_of<std::byte>(values, size));
        else
            misuse("put: there is no type " + std::to_string(type) + ".");
    });
}

int sluice_get(sluice_state* state, char const* name, int type, void const** values, size_t* size)
{
    return status_of([&] {
        auto const& kept =
            needed(needed(state, "get: state").restored, "get: the state is being saved; its restored part");
        std::string const key = &needed(name, "get: name");
        auto const give = [&](auto found) {
            needed(values, "get: values") = found.data();
            needed(size, "get: size") = found.size();
        };
        if (type == SLUICE_FLOAT64)
            give(kept.numbers(key));
        else if (type == SLUICE_INT64)
            give(kept.integers(key));
        else if (type == SLUICE_BYTES)
            give(kept.bytes(key));
        else
            misuse("get: there is no type " + std::to_string(type) + ".");
    });
}

}  // extern "C"
