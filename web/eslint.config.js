// What the code of the page must keep to, beyond its types.
import vue from 'eslint-plugin-vue'
import ts from 'typescript-eslint'

const BARE_EMIT =
  'a bare emit waits in a buffer while offline and is sent later: use socket.volatile or socket.timeout(ms)'

export default ts.config(
  { ignores: ['app-dist/**', 'node_modules/**', 'src/api/types.gen.ts'] },
  ...ts.configs.strict,
  ...ts.configs.stylistic,
  ...vue.configs['flat/recommended'],
  {
    files: ['**/*.vue'],
    languageOptions: { parserOptions: { parser: ts.parser } },
  },
  {
    rules: {
      'no-console': 'error',
      eqeqeq: ['error', 'always', { null: 'ignore' }],
      'no-restricted-syntax': [
        'error',
        {
          selector: "CallExpression[callee.property.name='emit'][callee.object.name=/[sS]ocket$/]",
          message: BARE_EMIT,
        },
        {
          selector:
            "CallExpression[callee.property.name=/^emit(WithAck)?$/][callee.object.property.name=/[sS]ocket$/]",
          message: BARE_EMIT,
        },
        {
          selector: "CallExpression[callee.property.name='emitWithAck'][callee.object.name=/[sS]ocket$/]",
          message: BARE_EMIT,
        },
      ],
      '@typescript-eslint/no-explicit-any': 'error',
      '@typescript-eslint/consistent-type-imports': 'error',
      'vue/component-api-style': ['error', ['script-setup']],
      'vue/define-props-declaration': ['error', 'type-based'],
      'vue/define-emits-declaration': ['error', 'type-literal'],
      'vue/no-v-html': 'error',
      'vue/block-order': ['error', { order: ['script', 'template', 'style'] }],
      // How it looks is nobody's argument here; lines may be as long as they read well.
      'vue/max-attributes-per-line': 'off',
      'vue/singleline-html-element-content-newline': 'off',
      'vue/multiline-html-element-content-newline': 'off',
      'vue/html-self-closing': 'off',
      'vue/html-closing-bracket-newline': 'off',
      'vue/html-indent': 'off',
      'vue/first-attribute-linebreak': 'off',
      'vue/attributes-order': 'off',
      'vue/multi-word-component-names': 'off',
      'vue/require-default-prop': 'off',
    },
  },
)
