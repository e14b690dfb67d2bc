// The bumper-like shell and its reference model, built once a test suite: it takes a second.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "tests/tracking/part/synthetic_cell.h"
#include "tracking/part/reference_model.h"

namespace deixis::synthetic {

class BumperModelTest : public testing::Test {
  protected:
    static void SetUpTestSuite() {
        mesh_ = new SurfaceMesh(bumper_shell(false));
        model_ = new std::shared_ptr<const ReferenceModel>(*ReferenceModel::build(*mesh_, {}));
    }
    static void TearDownTestSuite() {
        delete mesh_;
        delete model_;
    }

    static inline SurfaceMesh* mesh_ = nullptr;
    static inline std::shared_ptr<const ReferenceModel>* model_ = nullptr;
};

}  // namespace deixis::synthetic
