// How the page's modules are checked: `.ci/run` installs eslint and nothing else. Run from the root:
//   npx eslint --config tests/web/eslint.config.mjs --max-warnings 0 woosh_pure/web/page/js tests/web/page examples/web

const browser = [
  "AbortController", "AbortSignal", "Blob", "Headers", "ReadableStream", "CSS", "URL", "URLSearchParams", "WebSocket", "ResizeObserver", "addEventListener", "console",
  "createImageBitmap", "devicePixelRatio", "document", "fetch", "getComputedStyle", "globalThis", "history", "innerHeight", "innerWidth", "localStorage",
  "location", "matchMedia", "navigator", "performance", "requestAnimationFrame", "sessionStorage", "setInterval", "setTimeout", "structuredClone", "clearTimeout", "clearInterval",
  "TextDecoderStream",
];

const node = ["Event", "EventTarget"]; // of tests only

export default [
  {
    files: ["**/*.js", "**/*.mjs"],
    languageOptions: {
      ecmaVersion: 2023,
      sourceType: "module",
      globals: Object.fromEntries(browser.map((name) => [name, "readonly"])),
    },
    rules: {
      "array-callback-return": "error",
      "complexity": ["error", 20],
      "eqeqeq": "error",
      "max-len": ["error", { code: 130, ignoreStrings: true, ignoreTemplateLiterals: true }],
      "max-lines": ["error", 300],
      "no-const-assign": "error",
      "no-dupe-keys": "error",
      "no-empty": "error",
      "no-eval": "error",
      "no-fallthrough": "error",
      "no-implied-eval": "error",
      "no-redeclare": "error",
      "no-restricted-properties": [
        "error",
        { property: "innerHTML", message: "text goes in as text: see dom.js" },
        { property: "outerHTML", message: "text goes in as text: see dom.js" },
        { property: "insertAdjacentHTML", message: "text goes in as text: see dom.js" },
      ],
      "no-shadow": "error",
      "no-undef": "error",
      "no-unreachable": "error",
      "no-unused-vars": "error",
      "no-use-before-define": ["error", { functions: false, classes: false, variables: false }],
      "no-var": "error",
      "prefer-const": "error",
      "require-await": "error",
    },
  },
  {
    files: ["tests/**/*.mjs"],
    languageOptions: { globals: Object.fromEntries(node.map((name) => [name, "readonly"])) },
  },
];
