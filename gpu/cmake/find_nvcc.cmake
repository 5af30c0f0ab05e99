# Sets CMAKE_CUDA_COMPILER where nvcc is found.
if(NOT CMAKE_CUDA_COMPILER)
  find_program(EDGE_MCL_NVCC nvcc HINTS ENV CUDA_PATH ENV CUDACXX PATHS /usr/local/cuda
    PATH_SUFFIXES bin)
  if(EDGE_MCL_NVCC)
    set(CMAKE_CUDA_COMPILER "${EDGE_MCL_NVCC}")
  endif()
endif()
