// The fuzz program under libFuzzer:
//   cloudcontact_fuzz --target=NAME [options of libFuzzer] [corpora]
//   cloudcontact_fuzz --target=NAME --seeds=FOLDER           writes the seeds and ends
//   cloudcontact_fuzz --list                                 names the targets
#include "fuzz/fuzz_choice.h"

namespace {
cloudcontact::fuzz::Target chosen;
}

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  chosen = cloudcontact::fuzz::chosenTarget(*argc, *argv);
  chosen.run("");  // what is made once takes longer than an input may
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  if (size > chosen.longest) return -1;
  chosen.run({reinterpret_cast<const char*>(data), size});
  return 0;
}
