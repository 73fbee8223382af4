//! Runs a target over the files of folders, without a fuzzer: `fuzz_state DIRECTORY...`. A file named valid-* must be
//! taken, one named invalid-* refused; any other must only do no harm.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/fuzz/target.hpp"

int main(int argc, char** argv)
{
    std::vector<std::filesystem::path> files;
    for (int i = 1; i < argc; ++i)
        for (auto const& entry : std::filesystem::directory_iterator(argv[i]))
            if (entry.is_regular_file()) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    int wrong = 0;
    for (auto const& file : files) {
        std::ifstream in(file, std::ios::binary);
        std::vector<char> const bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
        auto const before = sluice::fuzz::accepted;
        LLVMFuzzerTestOneInput(reinterpret_cast<std::uint8_t const*>(bytes.data()), bytes.size());
        bool const taken = sluice::fuzz::accepted > before;
        auto const name = file.filename().string();
        if ((name.starts_with("valid-") && !taken) || (name.starts_with("invalid-") && taken)) {
            std::printf("%s was %s\n", file.c_str(), taken ? "taken" : "refused");
            ++wrong;
        }
    }
    std::printf("%zu files, %ld taken, %d not as named\n", files.size(), sluice::fuzz::accepted, wrong);
    return wrong > 0 || sluice::fuzz::accepted == 0 ? 1 : 0;
}
