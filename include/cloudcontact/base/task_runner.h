// How the library hands tasks to threads that the caller owns.
#pragma once

#include <functional>

namespace cloudcontact {

// Runs task(0) to task(count - 1), on any threads and in any order, and returns when all are done.
using TaskRunner = std::function<void(int count, const std::function<void(int)>& task)>;

}  // namespace cloudcontact
