// A store of the states of many points from C++: tickets, threads, and a file from which another process goes on.
//
//     c++ -std=c++17 -pthread -I include examples/stored_points.cpp -L ../../target/release -lgranum_c -o stored_points
//     ./stored_points states.granum
#include <array>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "granum.h"

namespace {

void check(int code) {
    if (code != GRANUM_OK) throw std::runtime_error(granum_last_error());
}

template <typename T, void (*Free)(T *)> struct Freed {
    void operator()(T *handle) const { Free(handle); }
};
using Point = std::unique_ptr<granum_point, Freed<granum_point, granum_point_free>>;
using State = std::unique_ptr<granum_state, Freed<granum_state, granum_state_free>>;
using Store = std::unique_ptr<granum_store, Freed<granum_store, granum_store_free>>;
using Six = std::array<double, 6>;

constexpr int points = 4;

/// Five increments of every point, each on a thread of its own; gives the stresses at the end.
std::vector<Six> steps(granum_store *store, granum_point *point, std::vector<std::uint64_t> &tickets) {
    std::vector<Six> stresses(points);
    std::vector<std::thread> threads;
    std::vector<int> codes(points, GRANUM_OK);
    for (int k = 0; k < points; ++k) {
        threads.emplace_back([&, k] {
            const Six strain = {1e-4 * (k + 1), 0, 0, 0, 0, 5e-5};
            for (int step = 0; step < 5 && codes[k] == GRANUM_OK; ++step)
                codes[k] = granum_store_advance(store, k, tickets[k], point, nullptr, strain.data(), nullptr, &tickets[k],
                                                stresses[k].data());
        });
    }
    for (auto &thread : threads) thread.join();
    for (int code : codes)
        if (code != GRANUM_OK) throw std::runtime_error("a point gave no answer");
    return stresses;
}

} // namespace

int main(int argc, char **argv) try {
    if (argc != 2) throw std::runtime_error("usage: stored_points FILE");
    const char *text = "grains.count = 50\ngrains.material.interface_energy = 0\npreparation.solid_fraction = 'none'\n"
                       "preparation.friction = 0.1\npreparation.mean_stress = '100 kPa'\npreparation.unbalanced_force = 0.1\n"
                       "preparation.inertial_number = 0.02\n";
    granum_point *made = nullptr;
    check(granum_point_from_case_text(text, nullptr, &made));
    Point point(made);
    granum_state *first = nullptr;
    check(granum_point_start(point.get(), &first));
    State start(first);
    granum_store *empty = nullptr;
    check(granum_store_new(&empty));
    Store store(empty);
    std::vector<std::uint64_t> tickets(points);
    for (int k = 0; k < points; ++k) check(granum_store_put(store.get(), k, start.get(), &tickets[k]));

    steps(store.get(), point.get(), tickets);
    check(granum_store_save(store.get(), argv[1]));
    auto read_tickets = tickets;
    const auto went_on = steps(store.get(), point.get(), tickets);

    granum_store *read = nullptr;
    check(granum_store_load(argv[1], &read));
    Store again(read);
    const auto from_file = steps(again.get(), point.get(), read_tickets);
    if (from_file != went_on || read_tickets != tickets) throw std::runtime_error("the file gave other bits");
    if (granum_store_advance(again.get(), 99, 1, point.get(), nullptr, went_on[0].data(), nullptr, &tickets[0], nullptr) !=
        GRANUM_ERROR_UNKNOWN)
        throw std::runtime_error("a point that does not exist gave an answer");
    std::printf("well: stress along x of point 3 is %.0f Pa, from the file as without it\n", went_on[3][0]);
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
