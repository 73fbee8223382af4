// A participant that says what another one said in a recorded run, so that its partners can be run without it.
#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <map>

#include "coupler/coupler.hpp"
#include "coupler/record/recording.hpp"
#include "coupler/session.hpp"
#include "coupler/wire/message.hpp"

namespace {

using namespace sluice;

//! The frames of a recording, edge by edge, in their order.
class Frames
{
 public:
    Frames(std::filesystem::path const& file, Participant const& self) : file_(file), reader_(file)
    {
        auto const& scene = self.scene();
        for (std::size_t e = 0; e < scene.edges.size(); ++e) {
            Edge const& edge = scene.edges[e];
            if (scene.participants[static_cast<std::size_t>(edge.from)].name != self.name()) continue;
            edges_.try_emplace(static_cast<std::uint32_t>(e),
                               Recorded{scene.participants[static_cast<std::size_t>(edge.to)].name,
                                        scene.data[static_cast<std::size_t>(edge.data)],
                                        FrameDecoder(scene.data[static_cast<std::size_t>(edge.data)], scene.dimension),
                                        {}});
        }
        auto const first = reader_.next();
        require(first && first->edge == recorded_window && first->bytes.size() == sizeof window_, [&] {
            return Error(file_.string() + ": not a recording of a participant's frames (made by sluice record).",
                         Exit::io);
        });
        std::memcpy(&window_, first->bytes.data(), sizeof window_);
    }

    double first_window() const { return window_; }  //!< s

    //! Ticks at frame `number` of any edge; nothing: the recording ends before.
    std::optional<std::int64_t> ticks(std::int64_t number)
    {
        if (edges_.empty()) return std::nullopt;
        auto const* const frame = find(edges_.begin()->second, number);
        return frame ? std::optional(frame->ticks) : std::nullopt;
    }

    //! Writes frame `number` of every edge.
    void write(Participant& self, std::int64_t number)
    {
        for (auto& [edge, recorded] : edges_) {
            auto const* const frame = find(recorded, number);
            require(frame != nullptr, [&] {
                return Error(file_.string() + ": ends before frame " + std::to_string(number) + " of " +
                                 recorded.spec.name + " to \"" + recorded.to + "\". Set a time.end that it covers.",
                             Exit::io);
            });
            std::vector<std::span<double const>> columns;
            for (auto const& column : frame->columns) columns.push_back(column.values);
            self.write(recorded.to, recorded.spec.name, frame->ids.values, columns);
        }
    }

 private:
    struct Recorded
    {
        std::string to;
        DataSpec spec;
        FrameDecoder decoder;
        std::deque<Frame> frames;
    };

    //! Reads on until the frame is there; older ones are forgotten.
    Frame const* find(Recorded& recorded, std::int64_t number)
    {
        for (;;) {
            while (!recorded.frames.empty() && recorded.frames.front().index < number) recorded.frames.pop_front();
            if (!recorded.frames.empty()) return &recorded.frames.front();
            auto const record = reader_.next();
            if (!record) return nullptr;
            auto const at = edges_.find(record->edge);
            require(at != edges_.end(), [&] {
                return Error(
                    file_.string() + ": has an edge that the scene does not have. Take the recorded run's scene.",
                    Exit::protocol);
            });
            auto const bytes = std::make_shared<Bytes>(record->bytes.begin(), record->bytes.end());
            auto const header = open_message(*bytes, file_.string());
            at->second.frames.push_back(at->second.decoder.decode(header, *bytes, bytes, file_.string()));
        }
    }

    std::filesystem::path file_;
    RecordingReader reader_;
    std::map<std::uint32_t, Recorded> edges_;
    double window_ = 0;
};

void replay(Participant& self)
{
    (void)self.rotation();        // what was recorded was in it
    auto config = self.config();  // the other keys are those of the solver that was recorded
    std::filesystem::path const file = config.text("recording");
    config.diagnostics()->throw_if_any();
    Frames frames(file, self);
    self.propose_window(frames.first_window(), true);
    if (self.checking()) return;
    // it looks at nothing that it is told: no column is sent to it, and no ledger misses what it does not take
    for (auto const& data : self.scene().data) self.reads(data.name, {});
    frames.write(self, 0);
    bool const paces = self.scene().participants[static_cast<std::size_t>(self.scene().pace)].name == self.name();
    Timescale const scale{frames.first_window()};
    for (Window const& window : self.windows()) {
        frames.write(self, window.index + 1);
        auto const now = frames.ticks(window.index + 1), next = frames.ticks(window.index + 2);
        if (paces && now && next) self.next_window(scale.seconds(*next - *now));
    }
}

}  // namespace

int main(int argc, char** argv)
{
    return sluice::run(argc, argv, replay);
}
