# Flags that every target of the project is compiled with.
add_library(clbvh_flags INTERFACE)
target_compile_features(clbvh_flags INTERFACE cxx_std_20)
# Contraction is off so that a distance computed here equals the kernels' to the bit. psabi: notes about gcc 4.6.
# Deprecated declarations: from 18 on, clang shows them within system headers too (llvm-project's issue 76515), such as that
# of libstdc++ 12 in std::stable_sort.
target_compile_options(clbvh_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wshadow -ffp-contract=off
  $<$<CXX_COMPILER_ID:GNU>:-Wno-psabi>
  $<$<AND:$<CXX_COMPILER_ID:Clang>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,18>>:-Wno-deprecated-declarations>
  $<$<BOOL:${CLBVH_WERROR}>:-Werror>)
if(CLBVH_SANITIZE)
  # gcc 12 with sanitizers warns of uninitialised values in <regex>, which Catch2 includes.
  target_compile_options(clbvh_flags INTERFACE
    -fsanitize=${CLBVH_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  target_link_options(clbvh_flags INTERFACE -fsanitize=${CLBVH_SANITIZE})
endif()

# clbvh_precompile(TARGET HEADERS...): what most files of the target include is parsed once.
function(clbvh_precompile target)
  if(CLBVH_PRECOMPILE)
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

# clbvh_join(TARGET NAME FILES...): FILES of the target are compiled as one. For rooms that take longer to parse than to
# compile; no two of their files may define the same name, not even in anonymous namespaces.
function(clbvh_join target name)
  set_source_files_properties(${ARGN} PROPERTIES UNITY_GROUP ${name})
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${CLBVH_UNITY} UNITY_BUILD_MODE GROUP)
endfunction()

# Vectors beyond the baseline of the processor that the library is compiled for.
include(CheckCXXSourceCompiles)
if(CLBVH_VECTORS)
  set(CMAKE_REQUIRED_FLAGS -mavx2)
  check_cxx_source_compiles("
    #if !defined(__x86_64__)
    #error
    #endif
    #include <immintrin.h>
    int main() { return _mm256_movemask_ps(_mm256_setzero_ps()) + __builtin_cpu_supports(\"avx2\"); }" CLBVH_HAS_AVX2)
  unset(CMAKE_REQUIRED_FLAGS)
endif()
