// The part of JSON Schema that contracts use, as types.

export interface Schema {
  type?: string | readonly string[]
  unit?: string
  format?: string
  description?: string
  title?: string
  enum?: readonly unknown[]
  const?: unknown
  default?: unknown
  minimum?: number
  maximum?: number
  exclusiveMinimum?: number
  exclusiveMaximum?: number
  multipleOf?: number
  minLength?: number
  maxLength?: number
  pattern?: string
  minProperties?: number
  properties?: Readonly<Record<string, Schema>>
  required?: readonly string[]
  items?: Schema
}

/** The first type that is not null. */
export function typeOf(schema: Schema): string {
  const types = typeof schema.type === 'string' ? [schema.type] : (schema.type ?? [])
  return types.find((one) => one !== 'null') ?? 'any'
}
