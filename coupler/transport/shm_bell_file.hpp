#pragma once

#include <new>
#include <optional>
#include <utility>

#include "coupler/transport/shm_bell.hpp"
#include "coupler/transport/shm_queue.hpp"

namespace sluice {

//! A file with a Bell behind the token that tells it from others.
class BellFile
{
 public:
    static constexpr std::size_t size = 64 * 1024;  // bytes: a multiple of every page size in use

    BellFile() : token_(random_token()), file_(SharedFile::create(size))
    {
        file_.allocate(0, size);
        page_ = file_.map(0, size, SharedFile::Access::write);
        content().token = token_;
    }
    static std::optional<BellFile> open(SharedFile::Address address, Token const& token)
    {
        auto file = SharedFile::open(address, size);
        if (!file) return std::nullopt;
        auto page = file->map(0, size, SharedFile::Access::write);
        BellFile bell(token, std::move(*file), std::move(page));
        if (bell.content().token != token) return std::nullopt;
        return bell;
    }
    Bell& operator*() { return content().bell; }
    Bell* operator->() { return &content().bell; }
    Token const& token() const { return token_; }
    SharedFile::Address address() const { return file_.address(); }

 private:
    struct Content
    {
        Token token;
        alignas(64) Bell bell;
    };
    BellFile(Token const& token, SharedFile file, Mapping page)
        : token_(token), file_(std::move(file)), page_(std::move(page))
    {}
    Content& content() { return *std::launder(reinterpret_cast<Content*>(page_.data())); }

    Token token_;
    SharedFile file_;
    Mapping page_;
};

}  // namespace sluice
