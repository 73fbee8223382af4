#include <sluice.h>

/* A mass of 1 kg between two springs; at the other end of one of them sits the partner. */
static int solve(sluice_participant* self)
{
    char const *const place[] = {"place", NULL}, *partner;
    double x, v = 0; /* m, m/s */
    double const* column = &x;
    size_t const size = 1;
    int64_t const id = 0;
    sluice_about about;
    sluice_window w;
    sluice_frame other;
    int s, more;
    if ((s = sluice_number(self, "start", "m", 1, NULL, &x)) || (s = sluice_exchanges(self, place, place)) ||
        (s = sluice_end_config(self)) || (s = sluice_get_about(self, &about)) || about.checking ||
        (s = sluice_partner(self, "place", 1, 0, &partner)))
        return s;
    if ((s = sluice_write(self, partner, "place", 1, &id, 1, &column, &size))) return s;
    while (!(s = sluice_next(self, &w, &more)) && more) {
        if ((s = sluice_read(self, partner, "place", w.begin, &other))) return s;
        v += w.length / 2 * (-39.5 * x - 157.9 * (x - other.column[0][0])); /* N over kg */
        x += w.length * v;
        if ((s = sluice_read(self, partner, "place", w.end, &other))) return s;
        v += w.length / 2 * (-39.5 * x - 157.9 * (x - other.column[0][0]));
        if ((s = sluice_write(self, partner, "place", 1, &id, 1, &column, &size))) return s;
    }
    return s ? s : sluice_fact(self, "place at the end [m]", x);
}

int main(int argc, char** argv)
{
    sluice_participant* self;
    int const s = sluice_join(SLUICE_ABI, argc, (char const* const*)argv, &self);
    return sluice_leave(self, s || !self ? s : solve(self), NULL);
}
