// A path tracer with a kernel of its own, on its own context, queue and buffers: the library makes the tree, and its
// OpenCL C traces the rays. The same paths are then traced on the host, and the two pictures compared.
//
//     path_tracer [PICTURE.ppm [WIDTH SAMPLES]]
#define CL_HPP_ENABLE_EXCEPTIONS
#define CL_HPP_MINIMUM_OPENCL_VERSION 120
#define CL_HPP_TARGET_OPENCL_VERSION 120
#include <CL/opencl.hpp>
#include <algorithm>
#include <clbvh/clbvh.hpp>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <vector>

namespace {

using std::sqrt;
using uint = std::uint32_t;
using float3 = clbvh::Vec3;
float3 make3(float x, float y, float z) {
    return {x, y, z};
}
float3 operator+(float3 a, float3 b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
float3 operator-(float3 a, float3 b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
float3 operator*(float3 a, float3 b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}
float3 operator*(float3 a, float b) {
    return {a.x * b, a.y * b, a.z * b};
}
#include "path.h"

struct Size {
    uint width, height, samples;
};

clbvh::Mesh hills() {
    constexpr uint kSide = 100;
    clbvh::Mesh mesh;
    for (uint i = 0; i < (kSide + 1) * (kSide + 1); ++i) {
        const auto x = static_cast<float>(i % (kSide + 1)), y = static_cast<float>(i / (kSide + 1));
        mesh.vertices.push_back({x, y, 9.0f * std::sin(0.15f * x) * std::cos(0.1f * y)});
    }
    for (uint i = 0; i < kSide * kSide; ++i) {
        const uint corner = i / kSide * (kSide + 1) + i % kSide;
        mesh.triangles.push_back({corner, corner + 1, corner + kSide + 1});
        mesh.triangles.push_back({corner + 1, corner + kSide + 2, corner + kSide + 1});
    }
    return mesh;
}

std::string read_file(const std::string& name) {
    std::ifstream file(std::string(PATH_TRACER_FOLDER) + "/" + name);
    return {std::istreambuf_iterator<char>(file), {}};
}

cl::Device first_device() {
    std::vector<cl::Platform> platforms;
    cl::Platform::get(&platforms);
    for (const cl::Platform& platform : platforms) {
        std::vector<cl::Device> devices;
        try {
            platform.getDevices(CL_DEVICE_TYPE_ALL, &devices);
        } catch (const cl::Error&) {  // it has none
        }
        if (!devices.empty()) return devices.front();
    }
    throw std::runtime_error("there is no OpenCL device");
}

// Whether the device promises the bits that processors have.
bool is_exact(const cl::Device& device) {
    constexpr cl_device_fp_config kNeeded = CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT | CL_FP_DENORM;
    return (device.getInfo<CL_DEVICE_SINGLE_FP_CONFIG>() & kNeeded) == kNeeded;
}

std::vector<float3> render_on_device(const cl::Device& device, const clbvh::Wide8& layout, const clbvh::Mesh& mesh,
                                     const Size& size) {
    const cl::Context context(device);
    cl::CommandQueue queue(context, device);
    const auto buffer_of = [&](const auto& array) {
        const std::size_t bytes = array.size() * sizeof(array[0]);
        return cl::Buffer(context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, bytes,
                          const_cast<void*>(static_cast<const void*>(array.data())));
    };
    const std::string make3 = "#pragma OPENCL FP_CONTRACT OFF\n#define make3(x, y, z) ((float3)(x, y, z))\n";
    const std::string source =
        std::string(clbvh::embed_source()) + make3 + read_file("path.h") + read_file("path_tracer.cl");
    cl::Program program(context, source);
    program.build(is_exact(device) ? "-cl-std=CL1.2 -cl-fp32-correctly-rounded-divide-sqrt" : "-cl-std=CL1.2");

    std::vector<float3> picture(size.width * size.height);
    const cl::Buffer result(context, CL_MEM_WRITE_ONLY, picture.size() * sizeof(float3));
    cl::KernelFunctor<cl::Buffer, cl::Buffer, uint, cl::Buffer, cl::Buffer, uint, uint, uint, cl::Buffer> render(
        program, "render");
    render(cl::EnqueueArgs(queue, cl::NDRange(picture.size())), buffer_of(layout.nodes), buffer_of(layout.blocks),
           static_cast<uint>(layout.blocks.size()), buffer_of(mesh.vertices), buffer_of(mesh.triangles), size.width,
           size.height, size.samples, result);
    queue.enqueueReadBuffer(result, CL_TRUE, 0, picture.size() * sizeof(float3), picture.data());
    return picture;
}

// What the kernel does, with the library's own tracer.
float3 pixel_on_host(const clbvh::Tracer& tracer, const clbvh::Mesh& mesh, const Size& size, uint pixel) {
    float3 sum{0.0f, 0.0f, 0.0f};
    for (uint sample = 0; sample < size.samples; ++sample) {
        uint state = pixel * size.samples + sample;
        float3 origin = eye(), direction = through_pixel(pixel, size.width, size.height, &state);
        float3 weight{1.0f, 1.0f, 1.0f};
        for (uint bounce = 0; bounce < BOUNCES; ++bounce) {
            const clbvh::Hit hit = tracer.closest({origin, RAY_BEGIN, direction});
            if (!hit) {
                sum = sum + weight * sky(direction);
                break;
            }
            const auto& [a, b, c] = mesh.triangles[hit.primitive];
            const float3 normal = normal_against(direction, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
            origin = origin + direction * hit.t;
            weight = weight * colour_of(hit.primitive);
            if (!tracer.any({origin, RAY_BEGIN, to_sun()})) sum = sum + weight * sunlight(normal);
            direction = scatter(normal, &state);
        }
    }
    return sum * (1.0f / static_cast<float>(size.samples));
}

void write_picture(const std::string& path, const std::vector<float3>& picture, const Size& size) {
    std::ofstream file(path, std::ios::binary);
    file << "P6\n" << size.width << ' ' << size.height << "\n255\n";
    for (const float3& pixel : picture) {
        for (const float value : {pixel.x, pixel.y, pixel.z})
            file.put(static_cast<char>(std::min(255.0f, 255.0f * sqrt(value / (1.0f + value)))));
    }
}

int run(const std::vector<std::string>& arguments) {
    Size size{64, 48, 4};
    if (arguments.size() > 2) {
        size.width = static_cast<uint>(std::stoul(arguments[1]));
        size.height = size.width * 3 / 4;
        size.samples = static_cast<uint>(std::stoul(arguments[2]));
    }
    const clbvh::Mesh mesh = hills();
    const clbvh::Bvh bvh = clbvh::build(mesh, "binned-sah");
    const auto layout = clbvh::make_layout<clbvh::Wide8>(bvh, mesh);
    const cl::Device device = first_device();
    const std::vector<float3> picture = render_on_device(device, layout, mesh, size);
    if (!arguments.empty()) write_picture(arguments[0], picture, size);

    const clbvh::Tracer tracer(layout);
    uint differences = 0;
    for (uint pixel = 0; pixel < picture.size(); ++pixel)
        differences += picture[pixel] == pixel_on_host(tracer, mesh, size, pixel) ? 0 : 1;
    std::cout << device.getInfo<CL_DEVICE_NAME>() << ": " << picture.size() << " pixels, " << differences
              << " unlike the host's\n";
    return differences == 0 || !is_exact(device) ? 0 : 1;
}

}  // namespace

int main(int count, char** arguments) {
    try {
        return run({arguments + 1, arguments + count});
    } catch (const cl::BuildError& error) {
        std::cerr << "path_tracer: " << error.getBuildLog().front().second << '\n';
    } catch (const std::exception& error) {
        std::cerr << "path_tracer: " << error.what() << '\n';
    }
    return 1;
}
