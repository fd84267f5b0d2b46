// SPDX-License-Identifier: Apache-2.0
// Never compiled: what the check of the includes must find.
#include "settings/cell_file.hpp"

#include <BulletCollision/btBulletCollisionCommon.h>
#include <assimp/scene.h>
#include <fastdds/dds/topic/Topic.hpp>
#include <libqhull_r/libqhull_r.h>
#include <ompl/base/Goal.h>
#include <urdf_parser/urdf_parser.h>
#include <yaml-cpp/yaml.h>
