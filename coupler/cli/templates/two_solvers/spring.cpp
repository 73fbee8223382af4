// A mass of 1 kg between two springs; at the other end of one of them sits the partner, another process of this
// program.

#include "coupler/coupler.hpp"

void solve(sluice::Participant& self)
{
    auto keys = self.config();  // the block config of this participant
    double x = keys.number("start", {.unit = "m"}), v = 0;
    self.sends({"place"});
    self.takes({"place"});
    keys.finish();                // a key that nobody asked for is a mistake
    if (self.checking()) return;  // started by `sluice check`

    auto const partner = self.receivers("place").at(0);
    std::int64_t const id = 0;
    auto tell = [&] { self.write(partner, "place", {&id, 1}, {{&x, 1}}); };
    tell();  // the state before the first window ...
    for (sluice::Window const& window : self.windows()) {
        auto other = self.read(partner, "place", window);
        auto pull = [&](double t) { return -39.5 * x - 157.9 * (x - other.columns(t)[0][0]); };  // N
        v += window.length / 2 * pull(window.begin);
        x += window.length * v;
        v += window.length / 2 * pull(window.end);
        tell();  // ... and at the end of each
    }
    self.fact("place at the end [m]", x);
}

int main(int argc, char** argv)
{
    return sluice::run(argc, argv, solve);
}
