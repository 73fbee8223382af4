#include "coupler/scene/threads.hpp"

#include <algorithm>
#include <charconv>
#include <string>
#include <thread>

namespace sluice {

int read_threads(Reader& reader, std::string_view fallback, int processes)
{
    std::string const text = reader.text_or("threads", fallback);
    if (text == "auto")
        return static_cast<int>(
            std::clamp(std::thread::hardware_concurrency() / static_cast<unsigned>(processes), 1U, 1024U));
    int threads = 0;
    auto const [end, error] = std::from_chars(text.data(), text.data() + text.size(), threads);
    if (error == std::errc{} && end == text.data() + text.size() && threads >= 1 && threads <= 1024) return threads;
    reader.problem("threads", text + " (must be auto, or 1 to 1024).");
    return 1;
}

}  // namespace sluice
