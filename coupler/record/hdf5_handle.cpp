#include "coupler/record/hdf5_handle.hpp"

#include <fmt/format.h>

#include "coupler/base/error.hpp"

namespace sluice::hdf5 {
namespace {

[[noreturn]] void fail(std::string const& what)
{
    throw Error(fmt::format("{}: {}. Free some space, or check the file.", what, reason()), Exit::io);
}

herr_t keep_description(unsigned /*depth*/, H5E_error2_t const* error, void* text)
{
    if (error->desc != nullptr && *error->desc != '\0') *static_cast<std::string*>(text) = error->desc;
    return 0;
}

}  // namespace

Quiet::Quiet()
{
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Quiet::~Quiet()
{
    H5Eset_auto2(H5E_DEFAULT, function_, data_);
}

void forbid_exit_handler()
{
    static herr_t const once = H5dont_atexit();
    static_cast<void>(once);
}

std::string reason()
{
    std::string text;
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, keep_description, &text);  // outermost first: the last is the innermost
    auto const start = text.find("error message = '");
    if (start != std::string::npos) text = text.substr(start + 17, text.find('\'', start + 17) - start - 17);
    return text.empty() ? "HDF5 gives no reason" : text;
}

Handle::Handle(hid_t id, Close close, std::string const& what) : id_(id), close_(close)
{
    if (id_ < 0) fail(what);
}

void Handle::close(std::string const& what)
{
    check(close_(std::exchange(id_, -1)), what);
}

void check(herr_t status, std::string const& what)
{
    if (status < 0) fail(what);
}

}  // namespace sluice::hdf5
