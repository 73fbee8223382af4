#pragma once

#include <filesystem>
#include <string>

#include "coupler/record/atomic_file.hpp"

namespace sluice::test {

//! Damages a file in one random way, a cut or a flipped bit, and mends it at the end of its life.
class Damage
{
 public:
    template <class Random>
    Damage(std::filesystem::path file, Random& random) : file_(std::move(file)), whole_(read_file(file_))
    {
        auto bytes = whole_;
        bool const cut = random() % 2 == 0;
        auto const at = static_cast<std::size_t>(random() % bytes.size());
        auto const bit = static_cast<int>(random() % 8);
        if (cut)
            bytes.resize(at);
        else
            bytes[at] = static_cast<char>(bytes[at] ^ (1 << bit));
        text_ = file_.filename().string() + (cut ? " cut to " + std::to_string(at)
                                                 : ", bit " + std::to_string(bit) + " of byte " + std::to_string(at));
        write_atomically(file_, bytes);
    }
    Damage(Damage const&) = delete;
    Damage& operator=(Damage const&) = delete;
    ~Damage() { write_atomically(file_, whole_); }
    std::string const& text() const { return text_; }

 private:
    std::filesystem::path file_;
    std::string whole_, text_;
};

}  // namespace sluice::test
