/* SPDX-License-Identifier: Apache-2.0 */
/* FMI 3.0, as much of it as a co-simulation unit without states of its own needs; by its standard.
 */
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

#define FMI3 __attribute__((visibility("default")))

FMI3 const char *fmi3GetVersion(void);
FMI3 fmi3Status fmi3SetDebugLogging(fmi3Instance instance, bool on, size_t n,
                                    const fmi3String categories[]);
FMI3 fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token,
                                              fmi3String resources, bool visible, bool logging,
                                              bool event_mode, bool early_return,
                                              const fmi3ValueReference intermediate[], size_t n,
                                              void *environment, fmi3Log log, void *update);
FMI3 void fmi3FreeInstance(fmi3Instance instance);
FMI3 fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, bool has_tolerance,
                                            double tolerance, double start, bool has_stop,
                                            double stop);
FMI3 fmi3Status fmi3ExitInitializationMode(fmi3Instance instance);
FMI3 fmi3Status fmi3Terminate(fmi3Instance instance);
FMI3 fmi3Status fmi3Reset(fmi3Instance instance);
FMI3 fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference refs[], size_t n,
                               double values[], size_t n_values);
FMI3 fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference refs[], size_t n,
                               const double values[], size_t n_values);
FMI3 fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference refs[], size_t n,
                               bool values[], size_t n_values);
FMI3 fmi3Status fmi3GetUInt64(fmi3Instance instance, const fmi3ValueReference refs[], size_t n,
                              uint64_t values[], size_t n_values);
FMI3 fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference refs[], size_t n,
                               const bool values[], size_t n_values);
FMI3 fmi3Status fmi3DoStep(fmi3Instance instance, double at, double step, bool no_set_state,
                           bool *event, bool *terminate, bool *early, double *reached);

/* A unit has every function of the standard. These refuse: modelDescription.xml offers none of
 * them. */
#define FMI3_NEVER(each) each(InstantiateModelExchange) each(InstantiateScheduledExecution)
#define FMI3_REFUSED(each)                                                                         \
  each(EnterEventMode) each(EnterConfigurationMode) each(ExitConfigurationMode) each(              \
      EnterStepMode) each(EnterContinuousTimeMode) each(CompletedIntegratorStep) each(GetFloat32)  \
      each(SetFloat32) each(GetInt8) each(SetInt8) each(GetUInt8) each(SetUInt8) each(GetInt16)    \
          each(SetInt16) each(GetUInt16) each(SetUInt16) each(GetInt32) each(SetInt32) each(       \
              GetUInt32) each(SetUInt32) each(GetInt64) each(SetInt64) each(SetUInt64)             \
              each(GetString) each(SetString) each(GetBinary) each(SetBinary) each(GetClock) each( \
                  SetClock) each(GetNumberOfVariableDependencies) each(GetVariableDependencies)    \
                  each(GetFMUState) each(SetFMUState) each(FreeFMUState) each(                     \
                      SerializedFMUStateSize) each(SerializeFMUState) each(DeserializeFMUState)    \
                      each(GetDirectionalDerivative) each(GetAdjointDerivative) each(              \
                          GetIntervalDecimal) each(GetIntervalFraction) each(SetIntervalDecimal)   \
                          each(SetIntervalFraction) each(GetShiftDecimal) each(GetShiftFraction)   \
                              each(SetShiftDecimal) each(SetShiftFraction)                         \
                                  each(EvaluateDiscreteStates) each(UpdateDiscreteStates)          \
                                      each(SetTime) each(SetContinuousStates)                      \
                                          each(GetContinuousStates)                                \
                                              each(GetContinuousStateDerivatives)                  \
                                                  each(GetNominalsOfContinuousStates)              \
                                                      each(GetNumberOfContinuousStates)            \
                                                          each(GetEventIndicators)                 \
                                                              each(GetNumberOfEventIndicators)     \
                                                                  each(GetOutputDerivatives)       \
                                                                      each(ActivateModelPartition)

#endif
