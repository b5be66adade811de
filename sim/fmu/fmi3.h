/* SPDX-License-Identifier: Apache-2.0 */
/* FMI 3.0, as much of it as a co-simulation unit needs; by its standard. */
#ifndef FMI3_H
#define FMI3_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef void *fmi3Instance;
typedef const char *fmi3String;
typedef uint32_t fmi3ValueReference;
typedef void (*fmi3Log)(void *environment, fmi3Status status, fmi3String category,
                        fmi3String message);

typedef void *fmi3FMUState;

/* A unit has every function of the standard. These refuse: modelDescription.xml offers none of
 * them. */
/* clang-format off */
#define FMI3_NEVER(each) each(InstantiateModelExchange) each(InstantiateScheduledExecution)
#define FMI3_REFUSED(each) \
  each(EnterEventMode) each(EnterConfigurationMode) each(ExitConfigurationMode) \
  each(EnterStepMode) each(EnterContinuousTimeMode) each(CompletedIntegratorStep) \
  each(GetFloat32) each(SetFloat32) each(GetInt8) each(SetInt8) each(GetUInt8) each(SetUInt8) \
  each(GetInt16) each(SetInt16) each(GetUInt16) each(SetUInt16) each(GetInt32) each(SetInt32) \
  each(GetUInt32) each(SetUInt32) each(GetInt64) each(SetInt64) each(SetUInt64) each(GetString) \
  each(SetString) each(GetBinary) each(SetBinary) each(GetClock) each(SetClock) \
  each(GetNumberOfVariableDependencies) each(GetVariableDependencies) \
  each(GetDirectionalDerivative) each(GetAdjointDerivative) each(GetIntervalDecimal) \
  each(GetIntervalFraction) each(SetIntervalDecimal) each(SetIntervalFraction) \
  each(GetShiftDecimal) each(GetShiftFraction) each(SetShiftDecimal) each(SetShiftFraction) \
  each(EvaluateDiscreteStates) each(UpdateDiscreteStates) each(SetTime) \
  each(SetContinuousStates) each(GetContinuousStates) each(GetContinuousStateDerivatives) \
  each(GetNominalsOfContinuousStates) each(GetNumberOfContinuousStates) each(GetEventIndicators) \
  each(GetNumberOfEventIndicators) each(GetOutputDerivatives) each(ActivateModelPartition)
/* clang-format on */

#endif
