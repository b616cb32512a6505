// A frame plan without furrow::gl: a small Vulkan host that records its items from nothing but the plan, the
// SPIR-V and the bindings. Skips where there is no Vulkan.

#include <gtest/gtest.h>
#include <vulkan/vulkan.h>

#include <cstring>
#include <stdexcept>
#include <vector>

#include "furrow/frame_plan.h"
#include "sheets.h"
#include "tests/image/ball_asset.h"

namespace furrow::tests {
namespace {

void require(VkResult result) {
  if (result != VK_SUCCESS) throw std::runtime_error("Vulkan answers " + std::to_string(result));
}

// A device with a queue for compute; every buffer is visible to the host.
class Device {
 public:
  Device() {
    const VkApplicationInfo application{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                        .pNext = nullptr,
                                        .pApplicationName = "furrow test",
                                        .applicationVersion = 0,
                                        .pEngineName = nullptr,
                                        .engineVersion = 0,
                                        .apiVersion = VK_API_VERSION_1_0};
    VkInstanceCreateInfo instance_info{};
    instance_info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    instance_info.pApplicationInfo = &application;
    require(vkCreateInstance(&instance_info, nullptr, &instance_));
    uint32_t count = 1;
    if (vkEnumeratePhysicalDevices(instance_, &count, &physical_) < 0 || count == 0)
      throw std::runtime_error("there is no Vulkan device");
    std::vector<VkQueueFamilyProperties> families(16);
    uint32_t family_count = 16;
    vkGetPhysicalDeviceQueueFamilyProperties(physical_, &family_count, families.data());
    while (family_ < family_count && !(families[family_].queueFlags & VK_QUEUE_COMPUTE_BIT)) ++family_;
    const float priority = 1.0f;
    VkDeviceQueueCreateInfo queue_info{};
    queue_info.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
    queue_info.queueFamilyIndex = family_;
    queue_info.queueCount = 1;
    queue_info.pQueuePriorities = &priority;
    VkDeviceCreateInfo device_info{};
    device_info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    device_info.queueCreateInfoCount = 1;
    device_info.pQueueCreateInfos = &queue_info;
    require(vkCreateDevice(physical_, &device_info, nullptr, &device_));
    vkGetDeviceQueue(device_, family_, 0, &queue_);
    VkCommandPoolCreateInfo pool_info{};
    pool_info.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    pool_info.queueFamilyIndex = family_;
    require(vkCreateCommandPool(device_, &pool_info, nullptr, &commands_));
  }
  ~Device() {
    if (device_) vkDestroyCommandPool(device_, commands_, nullptr);
    if (device_) vkDestroyDevice(device_, nullptr);
    if (instance_) vkDestroyInstance(instance_, nullptr);
  }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  VkDevice get() const { return device_; }

  VkDeviceMemory allocate(VkBuffer buffer) const {
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(device_, buffer, &needs);
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(physical_, &memory);
    constexpr VkMemoryPropertyFlags kWanted =
        VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    uint32_t type = 0;
    while (type < memory.memoryTypeCount && (!(needs.memoryTypeBits >> type & 1u) ||
                                             (memory.memoryTypes[type].propertyFlags & kWanted) != kWanted))
      ++type;
    VkMemoryAllocateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    info.allocationSize = needs.size;
    info.memoryTypeIndex = type;
    VkDeviceMemory result;
    require(vkAllocateMemory(device_, &info, nullptr, &result));
    require(vkBindBufferMemory(device_, buffer, result, 0));
    return result;
  }

  template <typename Record>
  void run(const Record& record) const {
    VkCommandBufferAllocateInfo allocate_info{};
    allocate_info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    allocate_info.commandPool = commands_;
    allocate_info.commandBufferCount = 1;
    VkCommandBuffer commands;
    require(vkAllocateCommandBuffers(device_, &allocate_info, &commands));
    VkCommandBufferBeginInfo begin_info{};
    begin_info.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    require(vkBeginCommandBuffer(commands, &begin_info));
    record(commands);
    require(vkEndCommandBuffer(commands));
    VkSubmitInfo submit{};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    require(vkQueueSubmit(queue_, 1, &submit, VK_NULL_HANDLE));
    require(vkQueueWaitIdle(queue_));
  }

 private:
  VkInstance instance_ = nullptr;
  VkPhysicalDevice physical_ = nullptr;
  VkDevice device_ = nullptr;
  VkQueue queue_ = nullptr;
  VkCommandPool commands_ = VK_NULL_HANDLE;
  uint32_t family_ = 0;
};

// Everything of one plan: its buffers, and a pipeline and descriptor sets for each dispatch.
class Host {
 public:
  Host(const Device& device, const FramePlan& plan) : device_(device), plan_(plan) {
    for (size_t i = 0; i < kBuffers; ++i) make(static_cast<Buffer>(i));
    makePool();
    for (const Item& item : plan.items())
      pipelines_.push_back(item.kind == ItemKind::kDispatch ? make(item) : Pipeline());
  }
  ~Host() {
    for (const Pipeline& p : pipelines_) {
      vkDestroyPipeline(device_.get(), p.pipeline, nullptr);
      vkDestroyPipelineLayout(device_.get(), p.layout, nullptr);
      for (VkDescriptorSetLayout set : p.set_layouts)
        vkDestroyDescriptorSetLayout(device_.get(), set, nullptr);
    }
    vkDestroyDescriptorPool(device_.get(), pool_, nullptr);
    for (size_t i = 0; i < kBuffers; ++i) {
      vkDestroyBuffer(device_.get(), buffers_[i], nullptr);
      vkFreeMemory(device_.get(), memory_[i], nullptr);
    }
  }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  std::byte* bytes(Buffer id) const { return mapped_[static_cast<size_t>(id)]; }

  void write(const FrameInput& input, uint32_t instance) const {
    const auto part = [&](Buffer id) {
      return std::span(bytes(id) + instance * plan_.instanceBytes(id), plan_.instanceBytes(id));
    };
    plan_.writeFrame(input, part(Buffer::kFrame));
    plan_.writeMorphWeights(input, part(Buffer::kMorphWeights));
    std::memcpy(part(Buffer::kPalette).data(), input.palette.data(), input.palette.size_bytes());
  }

  void run() const {
    device_.run([&](VkCommandBuffer commands) {
      for (size_t i = 0; i < pipelines_.size(); ++i) {
        const Item& item = plan_.items()[i];
        if (item.kind == ItemKind::kBarrier) {
          VkMemoryBarrier barrier{};
          barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
          barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
          barrier.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_HOST_READ_BIT;
          vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                               VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
                               &barrier, 0, nullptr, 0, nullptr);
          continue;
        }
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_[i].pipeline);
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines_[i].layout, 0, 2,
                                pipelines_[i].sets, 0, nullptr);
        vkCmdDispatch(commands, item.groups[0], item.groups[1], 1);
      }
    });
  }

 private:
  static constexpr size_t kBuffers = static_cast<size_t>(Buffer::kCount);
  struct Pipeline {
    VkDescriptorSetLayout set_layouts[2] = {};  // storage, uniform
    VkDescriptorSet sets[2] = {};
    VkPipelineLayout layout = VK_NULL_HANDLE;
    VkPipeline pipeline = VK_NULL_HANDLE;
  };

  // A buffer that the plan does not use is bound too, as a few bytes.
  void make(Buffer id) {
    const size_t i = static_cast<size_t>(id);
    const BufferDesc& desc = plan_.buffer(id);
    VkBufferCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = std::max<uint64_t>(desc.bytes, 16);
    info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT;
    require(vkCreateBuffer(device_.get(), &info, nullptr, &buffers_[i]));
    memory_[i] = device_.allocate(buffers_[i]);
    void* mapped = nullptr;
    require(vkMapMemory(device_.get(), memory_[i], 0, VK_WHOLE_SIZE, 0, &mapped));
    mapped_[i] = static_cast<std::byte*>(mapped);
    if (!desc.initial.empty()) std::memcpy(mapped, desc.initial.data(), desc.initial.size());
  }

  void makePool() {
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 128},
                                          {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 16}};
    VkDescriptorPoolCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
    info.maxSets = 16;
    info.poolSizeCount = 2;
    info.pPoolSizes = sizes;
    require(vkCreateDescriptorPool(device_.get(), &info, nullptr, &pool_));
  }

  Pipeline make(const Item& item) {
    Pipeline p;
    std::vector<VkDescriptorSetLayoutBinding> slots[2];
    for (const Binding& binding : item.bindings) {
      const bool uniform = binding.access == Access::kUniform;
      slots[uniform].push_back(
          {binding.slot, uniform ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1,
           VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    }
    for (int set = 0; set < 2; ++set) {
      VkDescriptorSetLayoutCreateInfo info{};
      info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
      info.bindingCount = static_cast<uint32_t>(slots[set].size());
      info.pBindings = slots[set].data();
      require(vkCreateDescriptorSetLayout(device_.get(), &info, nullptr, &p.set_layouts[set]));
    }
    VkDescriptorSetAllocateInfo sets_info{};
    sets_info.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
    sets_info.descriptorPool = pool_;
    sets_info.descriptorSetCount = 2;
    sets_info.pSetLayouts = p.set_layouts;
    require(vkAllocateDescriptorSets(device_.get(), &sets_info, p.sets));
    for (const Binding& binding : item.bindings) {
      const bool uniform = binding.access == Access::kUniform;
      const VkDescriptorBufferInfo buffer{buffers_[static_cast<size_t>(binding.buffer)], 0, VK_WHOLE_SIZE};
      VkWriteDescriptorSet write{};
      write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
      write.dstSet = p.sets[uniform];
      write.dstBinding = binding.slot;
      write.descriptorCount = 1;
      write.descriptorType = uniform ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
      write.pBufferInfo = &buffer;
      vkUpdateDescriptorSets(device_.get(), 1, &write, 0, nullptr);
    }
    VkPipelineLayoutCreateInfo layout_info{};
    layout_info.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    layout_info.setLayoutCount = 2;
    layout_info.pSetLayouts = p.set_layouts;
    require(vkCreatePipelineLayout(device_.get(), &layout_info, nullptr, &p.layout));
    const std::span<const uint32_t> spirv = shaderSource(item.shader).spirv;
    VkShaderModuleCreateInfo module_info{};
    module_info.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
    module_info.codeSize = spirv.size_bytes();
    module_info.pCode = spirv.data();
    VkShaderModule module;
    require(vkCreateShaderModule(device_.get(), &module_info, nullptr, &module));
    VkComputePipelineCreateInfo info{};
    info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = module;
    info.stage.pName = "main";
    info.layout = p.layout;
    const VkResult result =
        vkCreateComputePipelines(device_.get(), VK_NULL_HANDLE, 1, &info, nullptr, &p.pipeline);
    vkDestroyShaderModule(device_.get(), module, nullptr);
    require(result);
    return p;
  }

  const Device& device_;
  const FramePlan& plan_;
  VkBuffer buffers_[kBuffers] = {};
  VkDeviceMemory memory_[kBuffers] = {};
  std::byte* mapped_[kBuffers] = {};
  VkDescriptorPool pool_ = VK_NULL_HANDLE;
  std::vector<Pipeline> pipelines_;
};

class VulkanPlan : public testing::TestWithParam<Form> {
 protected:
  void SetUp() override {
    if (shaderSource(Shader::kCluster).spirv.empty()) GTEST_SKIP() << "built without SPIR-V";
    try {
      device_ = std::make_unique<Device>();
    } catch (const std::runtime_error& error) {
      GTEST_SKIP() << error.what();
    }
  }

  std::unique_ptr<Device> device_;
};

TEST_P(VulkanPlan, GivesTheWeightsOfTheJobs) {
  const BallAsset ball;
  const AssetView& asset = ball.view();
  const uint32_t instances = GetParam() == Form::kClustered ? 3 : 1;
  const FramePlan plan(asset, {.form = GetParam(), .point_q = true, .instances = instances});
  ASSERT_EQ(plan.options().form, GetParam());
  const Host host(*device_, plan);
  std::vector<Frame> expected;
  for (uint32_t i = 0; i < instances; ++i) {
    Affine pose;
    pose.m[4] = 0.3f * static_cast<float>(i + 1), pose.m[5] = 0.8f;
    const std::vector<Affine> palette(asset.palette.size(), pose);
    const std::vector<float> morphs = {0.5f - 0.1f * static_cast<float>(i)};
    expected.push_back(evaluate(asset, morphs, pose));
    FrameInput input;
    input.palette = palette;
    input.morph_weights = morphs;
    host.write(input, i);
  }
  host.run();
  for (uint32_t i = 0; i < instances; ++i) {
    const auto* positions = host.bytes(Buffer::kPositions) + i * plan.instanceBytes(Buffer::kPositions);
    EXPECT_EQ(std::memcmp(positions, expected[i].positions.data(), plan.instanceBytes(Buffer::kPositions)),
              0);
    const auto* q = host.bytes(Buffer::kPointQ) + i * plan.instanceBytes(Buffer::kPointQ);
    for (uint32_t l = 0; l < asset.layerCount(); ++l) {
      const size_t bytes = expected[i].q[l].size() * sizeof(float);
      EXPECT_EQ(std::memcmp(q + l * bytes, expected[i].q[l].data(), bytes), 0);
    }
    std::vector<int16_t> weights(expected[i].weights.size());
    std::memcpy(weights.data(), host.bytes(Buffer::kWeights) + i * plan.instanceBytes(Buffer::kWeights),
                weights.size() * sizeof(int16_t));
    int spread = 0;
    for (size_t v = 0; v < weights.size(); ++v) {
      ASSERT_NEAR(weights[v], expected[i].weights[v], 3);
      spread = std::max(spread, std::abs(static_cast<int>(weights[v])));
    }
    EXPECT_GT(spread, 10000);  // there was something to weigh
  }
}

INSTANTIATE_TEST_SUITE_P(Clustered, VulkanPlan, testing::Values(Form::kClustered));
INSTANTIATE_TEST_SUITE_P(Staged, VulkanPlan, testing::Values(Form::kStaged));

}  // namespace
}  // namespace furrow::tests
