#pragma once

#include <cstdlib>
#include <exception>
#include <iostream>

/// What run() returns, or failure with the message of what it throws.
template <typename Run>
int run_main(const Run& run) {
    try {
        return run();
    } catch (const std::exception& error) {
        std::cerr << error.what() << '\n';
        return EXIT_FAILURE;
    }
}
